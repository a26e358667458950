"""Which samples of a body's trajectory a sensor read anew: the rest repeat a reading or lie between two.

Simulated bodies rest without any noise, so equal poses tell nothing there. Where a sensor is noisy, two
readings are never equal: an equal one is an old one, as of a tag that a hand covers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array

ON_LINE = 1e-6
"""m from the straight line between its neighbours within which a sample was made from them."""
FEWEST = 6
"""steps between readings from which it can be told that they tremble."""


def fresh(t: Array, poses: Array) -> NDArray[np.bool_]:
    """(T,) which samples of poses (T, 7), all known, at seconds (T,) were read anew; the first one always."""
    mask = np.ones(len(t), bool)
    mask[1:] = (poses[1:] != poses[:-1]).any(axis=1)
    if len(t) > 2:
        u = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
        off = poses[1:-1, :3] - (1 - u) * poses[:-2, :3] - u * poses[2:, :3]
        moved = (poses[1:, :3] != poses[:-1, :3]).any(axis=1)
        mask[1:-1] &= (np.abs(off) > ON_LINE).any(axis=1) | ~(moved[1:] & moved[:-1])
    return mask


def trembling(t: Array, poses: Array) -> float:
    """How much a sensor's readings of poses (T, 7) tremble, metres per axis; 0 where motion explains them.

    A body that moves goes on the way it went; noise goes back. So the steps between a noisy sensor's readings
    are correlated by −σ² per axis, and those of a motion are not, however quick it is.
    """
    steps = np.diff(poses[fresh(t, poses), :3], axis=0)
    if len(steps) < FEWEST:
        return 0.0
    back = -float(np.median(np.sum(steps[1:] * steps[:-1], axis=1)))
    return float(np.sqrt(max(back, 0.0) / 3))
