"""Lengths that cannot be metres: refused, with the line of a mapping that mends them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.suggestion import suggested_sizes

WIDEST = 10.0
"""m that what is on a table, and a hand over it, lie apart at most."""
WIDEST_HAND = 1.0
"""m between its fingertips at most."""
LARGEST = 5.0
"""m of an object's longest side at most."""
SMALLEST = 5e-4
"""m of it at least."""
_LOOKED_AT = 200
"""frames, at most: positions in another unit are so in every frame."""


def check_lengths(path: Path, demonstration: Demonstration) -> None:
    """Raises FileError for positions, sizes or an opening that are no metres."""
    longest = demonstration.object_sizes.max(axis=1)
    largest = float(np.nanmax(longest, initial=0))
    apart = _apart(demonstration)
    if apart > WIDEST:
        unit, word = ("mm", "millimetres") if apart >= 100 or largest > 20 else ("cm", "centimetres")
        raise FileError(
            path,
            f"its positions lie {apart:.0f} apart, which cannot be metres",
            f'If they are {word}, say so in a mapping (--mapping FILE.toml): length_unit = "{unit}".',
        )
    opened = demonstration.opening
    if opened is not None and np.nanmax(opened, initial=0) > WIDEST_HAND:
        problem = f"opens the hand by {np.nanmax(opened):g}, which cannot be metres"
        raise FileError(path, problem, "Give metres between the fingertips, or leave the opening out.")
    with np.errstate(invalid="ignore"):
        wrong = (longest > LARGEST) | (longest < SMALLEST)
    if wrong.any():
        k, names = int(np.argmax(wrong)), demonstration.object_names
        said = " × ".join(f"{side:g}" for side in demonstration.object_sizes[k])
        factors = np.where(wrong, np.where(longest > LARGEST, 1e-3, 1e3), 1.0)
        mended = dict(zip(names, demonstration.object_sizes * factors[:, None], strict=True))
        raise FileError(
            path,
            f"gives {names[k]!r} a size of {said}, which cannot be metres: positions lie {apart:.2g} apart",
            "Say it in a mapping, and pass it with --mapping FILE.toml:\n\n" + suggested_sizes(mended),
        )


def _apart(demonstration: Demonstration) -> float:
    """The longest side of a box around nearly all positions, in the file's unit."""
    d = demonstration
    frames = slice(None, None, max(1, len(d.t) // _LOOKED_AT))
    positions = np.concatenate([d.hand[frames, None, :3], d.objects[frames, :, :3]], axis=1).reshape(-1, 3)
    low, high = np.nanpercentile(positions, [5, 95], axis=0)
    return float((high - low).max())
