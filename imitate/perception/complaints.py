"""What to say of a recording or a cloud in which something is missing: looked for, found, and what to do."""

from __future__ import annotations

import numpy as np

from imitate.geometry import Array
from imitate.perception.first_view import FirstView
from imitate.settings import Perception

_COLOURS = "a hue's name, '#rrggbb', or the place of a pixel U,V of the first picture"


def one_frame(name: str, count: int) -> str:
    """Of a recording with fewer than two frames."""
    had = "no frame" if count == 0 else "one frame"
    return (
        f"{name}: has {had}; a demonstration needs at least 2. A single view is observed as a cloud, from a "
        "PCD or PLY file."
    )


def no_table(name: str, why: str, points: Array) -> str:
    """Of a view without a table; ``points`` (N, 3) metres, NaN where nothing was read."""
    z = points[np.isfinite(points).all(axis=1) & (points[:, 2] > 0), 2]
    if not len(z):
        found = "no point lies before the camera"
    else:
        low, middle, high = np.percentile(z, [5, 50, 95])
        found = f"its {len(z):,} readings lie {low:.3g} to {high:.3g} m away, the middle one {middle:.3g} m"
    return (
        f"{name}: {why.rstrip('.')}; {found}. Expected a table 0.3 to 4 m away, seen from above, with things "
        "on it. Where the distances are wrong, the unit is: --depth-unit 0.001 for millimetres, 0.0002 for "
        "5000 steps a metre."
    )


def no_block(name: str, first: FirstView, settings: Perception) -> str:
    """Of a table with nothing on it that can be followed."""
    others = ", ".join(thing.name for thing in first.objects)
    found = f"on the table: {others}" if others else "on the table there is nothing"
    return (
        f"{name}: no block that can be followed in the first view; {found}. Blocks are coloured, at least "
        f"1.5 cm high, apart from each other, and not {settings.left_finger} or {settings.right_finger}, "
        "which are the fingers' (--left-finger, --right-finger)."
    )


def no_hand(name: str, settings: Perception) -> str:
    """Of a recording in which the hand was never seen."""
    return (
        f"{name}: no hand: in no frame are a {settings.left_finger} finger on the left and a "
        f"{settings.right_finger} one on the right. Pass their colours with --left-finger and "
        f"--right-finger: {_COLOURS}."
    )
