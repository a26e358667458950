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

from imitate.demonstration import HAND, Demonstration
from imitate.errors import FileError
from imitate.formats.frames_in_time import frames_in_time
from imitate.formats.mapping import Mapping
from imitate.formats.opening import OPENING
from imitate.formats.table import AXES, SIZES, Table

_SIZES = "object_sizes"
_NEEDED = ("t", "hand", "objects", "object_names")
_REMEDY = (
    "A demonstration holds t (T,), hand (T, 7), objects (T, K, 7), object_names (K,) and, where known, "
    "object_sizes (K, 3) and opening (T,)."
)


def read_npz(path: Path, notes: list[str]) -> Demonstration:
    """The demonstration of an archive whose arrays have our own names; ``notes`` gets what ought to be known.

    Raises:
        FileError: no such archive.
        DemonstrationError: what it holds is no demonstration.
    """
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
    lengths = {len(array) for name, array in arrays.items() if name != _SIZES and array.ndim}
    if arrays["t"].ndim == 1 and len(lengths) == 1:
        arrays["t"], rows = frames_in_time(path, np.asarray(arrays["t"], float), None, Mapping(), notes)
        arrays |= {name: arrays[name][rows] for name in arrays if name not in ("t", _SIZES)}
    return Demonstration(object_names=names, **arrays)


def npz_table(path: Path) -> Table:
    """The arrays as columns; one of more than two dimensions has its rows laid out flat."""
    held = {name: array for name, array in _with_columns(_arrays(path)).items() if array.ndim and len(array)}
    widths = {name: array[0].size if array.dtype.kind in "fiub" else None for name, array in held.items()}
    return Table(path, widths, held.__getitem__)


def _with_columns(held: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Our own arrays under the names that columns have, so that a mapping may say what differs in them."""
    hand, objects, names = (held.get(name) for name in _NEEDED[1:])
    if hand is None or objects is None or names is None or hand.ndim != 2 or objects.ndim != 3:
        return held
    sizes = held.get(_SIZES)
    columns = {name: array for name, array in held.items() if name not in (*_NEEDED[1:], _SIZES)}
    for name, poses in ((HAND, hand), *zip(map(str, names), np.moveaxis(objects, 1, 0), strict=False)):
        columns |= {f"{name}_{axis}": poses[:, k] for k, axis in enumerate(AXES)}
    for name, size in zip(map(str, names), sizes if sizes is not None else (), strict=False):
        columns |= {f"{name}_{axis}": np.full(len(hand), size[k]) for k, axis in enumerate(SIZES)}
    return columns


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
