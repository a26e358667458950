"""Demonstration ⇄ NPZ.

It holds t (T,), hand (T, 7), objects (T, K, 7), object_names (K,) and, where known, object_sizes (K, 3) and
opening (T,). With a mapping, any arrays of one length are columns.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.opening import OPENING
from imitate.formats.table import Table

_SIZES = "object_sizes"
_NEEDED = ("t", "hand", "objects", "object_names")
_REMEDY = (
    "A demonstration holds t (T,), hand (T, 7), objects (T, K, 7), object_names (K,) and, where known, "
    "object_sizes (K, 3) and opening (T,)."
)


def read_npz(path: Path) -> Demonstration:
    """Raises FileError for what is no such archive, DemonstrationError for what is no demonstration."""
    held = _arrays(path)
    missing = [name for name in _NEEDED if name not in held]
    if missing:
        has = ", ".join(f"{name} {array.shape}" for name, array in held.items()) or "nothing"
        raise FileError(path, f"has no array {' and no '.join(map(repr, missing))}; it has {has}", _REMEDY)
    names = tuple(str(name) for name in np.atleast_1d(held["object_names"]))
    sizes = held.get(_SIZES, np.full((len(names), 3), np.nan))
    arrays = {**{name: held[name] for name in _NEEDED[:3]}, _SIZES: sizes}
    if OPENING in held:
        arrays[OPENING] = held[OPENING]
    for name, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise FileError(path, f"{name} holds {array.dtype}, not numbers", _REMEDY)
    return Demonstration(object_names=names, **arrays)


def npz_table(path: Path) -> Table:
    """The arrays as columns; one of more than two dimensions has its rows laid out flat."""
    held = {name: array for name, array in _arrays(path).items() if array.ndim and len(array)}
    widths = {name: array[0].size if array.dtype.kind in "fiub" else None for name, array in held.items()}
    return Table(path, widths, held.__getitem__)


def write_npz(demonstration: Demonstration, stream: IO[bytes]) -> None:
    """Writes everything, bit for bit."""
    opening: dict[str, Any] = {} if demonstration.opening is None else {OPENING: demonstration.opening}
    np.savez_compressed(
        stream,
        t=demonstration.t,
        hand=demonstration.hand,
        objects=demonstration.objects,
        object_names=np.array(demonstration.object_names),
        object_sizes=demonstration.object_sizes,
        **opening,
    )


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    if not zipfile.is_zipfile(path):
        start = path.read_bytes()[:8]
        held_instead = f"it starts with {start!r}" if start else "it is empty"
        raise FileError(path, f"is not an NPZ archive: {held_instead}", _REMEDY)
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except Exception as error:  # on damage zipfile, zlib, tokenize and numpy raise nearly everything
        raise FileError(path, f"is not an NPZ archive of plain arrays ({error})", _REMEDY) from None
