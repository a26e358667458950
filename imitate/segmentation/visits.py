"""Objects that a free hand visits: it goes there, touches them for a while, and goes on."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.geometry import Array, relative, resample
from imitate.segmentation.rests import resting
from imitate.settings import Segmentation

Visits = Sequence[tuple[int, int, int]]
"""(start, end, object): frames start…end−1 of each visit."""


def visits(demonstration: Demonstration, times: Array, settings: Segmentation) -> Visits:
    """Where the hand rests on an object, in order; none on objects whose size is not known.

    Args:
        demonstration: every pose known.
        times: (T,) seconds since the first frame.
    """
    if settings.mode != "robust" or np.isnan(demonstration.object_sizes).all():
        return ()
    t = demonstration.t - demonstration.t[0]
    hand = resample(t, demonstration.hand, times)
    away = np.full((len(times), len(demonstration.object_names)), np.inf)
    for k, name in enumerate(demonstration.object_names):
        inside = relative(resample(t, demonstration.pose_of(name), times), hand)[:, :3]
        outside = np.maximum(np.abs(inside) - demonstration.size_of(name) / 2, 0)
        away[:, k] = np.linalg.norm(outside, axis=1)
    away = np.where(np.isnan(away), np.inf, away)
    touched = np.where(away.min(axis=1) <= settings.touch, away.argmin(axis=1), -1)
    touched[~resting(demonstration, times, settings)] = -1
    least = settings.visit * (len(times) - 1) / times[-1]
    return [(a, b, k) for a, b, k in _runs(touched) if k >= 0 and b - a >= least]


def visited(found: Visits, start: int, end: int) -> tuple[int, ...]:
    """The object last visited, if any, by a hand that came to it after ``start`` and left it by ``end``."""
    return tuple(k for a, b, k in found if start < a and b <= end)[-1:]


def with_visits(
    cuts: Sequence[int], carried: Sequence[tuple[str, ...]], found: Visits, names: Sequence[str]
) -> tuple[int, ...]:
    """Cuts and, within each free segment, those where the hand leaves one object for another.

    A visit that lasts to the end of its segment is the grasp of what is held next.

    Args:
        cuts: (0, …, T) in frames.
        carried: for each segment, the names of what is held in it.
        found: all visits, in order.
    """
    more = set(cuts)
    for (start, end), now, after in zip(pairwise(cuts), carried, [*carried[1:], ()], strict=True):
        if now:
            continue
        inside = [(b, (names[k],)) for a, b, k in found if start < a and b < end]
        reached = [there for _, there in inside] + ([after] if after else [])
        more |= {b for (b, there), on in zip(inside, reached[1:], strict=False) if there[0] not in on}
    return tuple(sorted(more))


def _runs(values: NDArray[np.int_]) -> Visits:
    ends = np.flatnonzero(np.append(np.diff(values) != 0, True)) + 1
    starts = np.append(0, ends[:-1])
    return [(int(a), int(b), int(values[a])) for a, b in zip(starts, ends, strict=True)]
