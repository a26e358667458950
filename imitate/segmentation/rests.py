"""Whose the rests are: frames in which the hand waits next to a carry go to the carry.

The score cuts where the object starts and stops to move. The fingers close before and open after that, while
the hand rests, so a carry that is to be learned with its gripper has to have those frames.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.geometry import Array, resample
from imitate.segmentation.robust import noise
from imitate.settings import Segmentation


def resting(demonstration: Demonstration, times: Array, settings: Segmentation) -> NDArray[np.bool_]:
    """Whether the hand rests at each of ``times`` (seconds since the first frame), noise allowed for."""
    t = demonstration.t - demonstration.t[0]
    half = settings.window / settings.rate / 2
    before, after = np.clip(times - half, 0, t[-1]), np.clip(times + half, 0, t[-1])
    moved = resample(t, demonstration.hand, after) - resample(t, demonstration.hand, before)
    sigma = noise(t, demonstration.hand[:, None, :3])[0]
    # Noise alone moves a resting hand by more than 4σ in 5 % of the frames.
    allowed = np.hypot(settings.rest_speed * (after - before), 4 * sigma)
    return np.asarray(np.linalg.norm(moved[:, :3], axis=1) <= allowed)


def rests_to_carries(
    cuts: Sequence[int],
    carries: Sequence[bool],
    rests: NDArray[np.bool_],
    most: int,
    shortest: int,
) -> tuple[int, ...]:
    """Cuts moved away from carries for as long as the hand rests.

    Args:
        cuts: (0, …, T) in frames.
        carries: for each segment, whether something is held in it.
        rests: (T,) whether the hand rests.
        most: frames by which a cut moves at most.
        shortest: frames that are left to a segment.
    """
    moved = list(cuts)
    for k in range(1, len(cuts) - 1):
        if carries[k] and not carries[k - 1]:
            bound = max(moved[k] - most, moved[k - 1] + shortest)
            while moved[k] > bound and rests[moved[k] - 1]:
                moved[k] -= 1
        elif carries[k - 1] and not carries[k]:
            bound = min(moved[k] + most, cuts[k + 1] - shortest)
            while moved[k] < bound and rests[moved[k]]:
                moved[k] += 1
    return tuple(moved)
