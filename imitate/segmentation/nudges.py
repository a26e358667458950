"""Objects that are nudged in passing: they go with the hand for a moment, but nobody carries them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from imitate.demonstration import Demonstration
from imitate.geometry import Array, angle_between, compose, inverse, resample
from imitate.settings import Segmentation


@dataclass(frozen=True)
class Nudge:
    """Frames start…end−1 in which the object of index ``body`` is moved in passing."""

    start: int
    end: int
    body: int


def nudges(
    cuts: Sequence[int],
    carried: Sequence[tuple[str, ...]],
    demonstration: Demonstration,
    times: Array,
    settings: Segmentation,
) -> tuple[Nudge, ...]:
    """Carries that move their object nowhere: by less than ``settings.nudge`` all along.

    Args:
        cuts: (0, …, T) in frames.
        carried: for each segment, the names of what is held in it.
        demonstration: what was cut, every pose known.
        times: (T,) seconds since the first frame.
    """
    t = demonstration.t - demonstration.t[0]
    hand = resample(t, demonstration.hand, times)
    width = max(1, round(settings.window / (times[1] - times[0])))
    found = []
    for (start, end), names in zip(pairwise(cuts), carried, strict=True):
        for name in names:
            body = resample(t, demonstration.pose_of(name), times[start:end])
            if np.max(median_filter(_moved(body, hand[start], settings), width)) < settings.nudge:
                found.append(Nudge(start, end, demonstration.object_names.index(name)))
    return tuple(found)


def _moved(body: Array, hand: Array, settings: Segmentation) -> Array:
    """(T,) metres that the point of a body (T, 7) under the hand (7,) is away from where it was first.

    Turning by an angle counts as moving by that times ``hand_radius``.
    """
    along = compose(compose(body, inverse(body[0])), hand)
    shifted = np.linalg.norm(along[:, :3] - hand[:3], axis=1)
    return np.asarray(np.hypot(shifted, settings.hand_radius * angle_between(body, body[0])))
