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
        found = (
            "no point lies before the camera, which looks along z. Where the points are given in another "
            "frame, --sensor says which: graphics (y up, z towards the sensor), body (x forward, z up), "
            "viewpoint, or the camera's pose in it"
        )
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
    low, high = first.table.low, first.table.high
    sides = " × ".join(f"{side:.2f}" for side in high - low)
    return (
        f"{name}: nothing to follow stands on the table in the first view. The table found is {sides} m, "
        f"{first.table.inliers:,} points of it. Looked for blocks on it of at least 1.5 cm, apart from each "
        f"other and not of the fingers' colours, {settings.left_finger} and {settings.right_finger} "
        "(--left-finger, --right-finger)."
    )


def no_hand(name: str, settings: Perception) -> str:
    """Of a recording in which the hand was never seen."""
    return (
        f"{name}: no hand: in no frame are a {settings.left_finger} finger on the left and a "
        f"{settings.right_finger} one on the right. Pass their colours with --left-finger and "
        f"--right-finger: {_COLOURS}."
    )
