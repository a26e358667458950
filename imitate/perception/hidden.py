"""What may be hidden of a thing: an end of it, or all that lies behind what stands before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imitate.geometry import Array
from imitate.perception.shapes import Mask, Pixels
from imitate.perception.things import spacing

UNKNOWN = 0.03
"""m, standard deviation of a side from which it is not known."""
BESIDE = 5 / 525
"""rad between a thing's edge and what may hide more of it: five of a Kinect's pixels."""
CUT = 0.15
"""share of a thing's edge that another thing cuts off, from which it may go on behind that."""


def hidden_end(deviation: Array) -> str:
    """Why a size with this standard deviation (3,), metres, is not known, in words; empty where it is."""
    if deviation.max() < UNKNOWN:
        return ""
    return (
        f"an end of it is hidden, a side is known to ± {1000 * deviation.max():.0f} mm only: it may be a "
        "part of what is unsure here"
    )


def cut_off(pixels: Pixels, own: NDArray[np.intp], strange: Mask, tolerance: float) -> str:
    """Why a thing may be a part of something, in words; empty where little of its outline is cut off.

    Args:
        pixels: of the whole view.
        own: (K,) which show the thing.
        strange: (M,) which show something that is neither the table nor a sure thing.
        tolerance: metres that noise and the pixels' width explain.
    """
    others = np.setdiff1d(np.flatnonzero(strange), own)
    mine, theirs = _directions(pixels, own), _directions(pixels, others)
    if not len(others):
        return ""
    away, which = map(np.asarray, cKDTree(theirs).query(mine, distance_upper_bound=BESIDE))
    beside = np.flatnonzero(np.isfinite(away))
    before = pixels.depth[others[which[beside]]] < pixels.depth[own[beside]] - tolerance
    outline = 4 * np.sqrt(len(own)) * max(BESIDE / max(spacing(mine), 1e-9), 1)  # of a square, so wide a rim
    share = min(float(before.sum() / outline), 1.0)
    if share < CUT:
        return ""
    return f"it may go on behind something unsure that stands before {share:.0%} of its outline"


def _directions(pixels: Pixels, some: NDArray[np.intp]) -> Array:
    rays = pixels.rays[some].astype(float)
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))
