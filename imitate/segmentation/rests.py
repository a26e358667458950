"""Where a carry starts and ends, for learning: with the rests beside it.

The search cuts where the object starts and stops to move. The fingers close before and open after that, while
the hand rests, so a carry that is to be learned with its gripper has to have those frames.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.geometry import Array, compose, relative, resample
from imitate.segmentation.tracks import noise
from imitate.settings import Segmentation


def with_rests(
    cuts: Sequence[int],
    carried: Sequence[tuple[str, ...]],
    demonstration: Demonstration,
    times: Array,
    settings: Segmentation,
) -> tuple[int, ...]:
    """Cuts whose carries have the rests beside them.

    Args:
        cuts: (0, …, T) in frames.
        carried: for each segment, the names of what is held in it.
        demonstration: what was cut, every pose known.
        times: (T,) seconds since the first frame.
        settings: ``rest_limit`` bounds how far a cut moves at a time.
    """
    t = demonstration.t - demonstration.t[0]
    a_second = (len(times) - 1) / times[-1]
    most, shortest = round(settings.rest_limit * a_second), max(1, round(settings.shortest * a_second))
    if most == 0:
        return tuple(cuts)
    hand = resample(t, demonstration.hand, times)
    names = {name for held in carried for name in held}
    tracks = {name: resample(t, demonstration.pose_of(name), times) for name in names}
    for k in range(1, len(cuts) - 1):
        if carried[k - 1] and not carried[k]:
            first, last = cuts[k - 1], cuts[k + 1]
            grips = [grip(hand, tracks[name], first, cuts[k], last) for name in carried[k - 1]]
            local = (0, cuts[k] - first, last - first)
            _, moved, _ = let_go(local, 1, hand[first:last, :3], np.stack(grips, axis=1), most, shortest)
            cuts = (*cuts[:k], first + moved, *cuts[k + 1 :])
    carries = [bool(names) for names in carried]
    return rests_to_carries(cuts, carries, resting(demonstration, times, settings), most, shortest)


def grip(hand: Array, body: Array, start: int, end: int, last: int) -> Array:
    """The point of a body (T, 7) where the hand (T, 7) has it from frame ``start`` to ``end``.

    Returns:
        (last − start, 3) where that point is from frame ``start`` to ``last``.
    """
    held = relative(body[start:end], hand[start:end])[:, :3]
    where = np.append(np.median(held, axis=0), [0.0, 0, 0, 1])
    return compose(body[start:last], where)[:, :3]


def resting(demonstration: Demonstration, times: Array, settings: Segmentation) -> NDArray[np.bool_]:
    """Whether the hand rests at each of ``times`` (seconds since the first frame), noise allowed for."""
    t = demonstration.t - demonstration.t[0]
    half = settings.window / 2
    before, after = np.clip(times - half, 0, t[-1]), np.clip(times + half, 0, t[-1])
    moved = resample(t, demonstration.hand, after) - resample(t, demonstration.hand, before)
    sigma = noise(t, demonstration.hand)
    # Noise alone moves a resting hand by more than 4σ in 5 % of the frames.
    allowed = np.hypot(settings.rest_speed * (after - before), 4 * sigma)
    return np.asarray(np.linalg.norm(moved[:, :3], axis=1) <= allowed)


def let_go(
    cuts: Sequence[int], k: int, hand: Array, held: Array, reach: int, shortest: int
) -> tuple[int, ...]:
    """Cut ``k``, at the end of a carry, put where what was held stops to go with the hand.

    The search's evidence is displacement over a short window, which slow lowering in noise hardly shows. Here
    whole stretches count: the least squares of ‖(o − h) − mean‖ before the cut and ‖o − mean‖ after it.

    Args:
        hand: (T, 3) positions in metres.
        held: (T, H, 3) positions of what was held.
        reach: frames by which the cut moves at most; twice as many are looked at.
        shortest: frames that are left to a segment.
    """
    first, last = max(cuts[k - 1], cuts[k] - 2 * reach), min(cuts[k + 1], cuts[k] + 2 * reach)
    still = held[first:last]
    cost = _squares(still - hand[first:last, None]) + _squares(still[::-1])[::-1]
    frames = np.arange(first, last + 1)
    near = np.abs(frames - cuts[k]) <= reach
    allowed = near & (frames >= cuts[k - 1] + shortest) & (frames <= cuts[k + 1] - shortest)
    if not allowed.any():
        return tuple(cuts)
    return (*cuts[:k], int(frames[allowed][np.argmin(cost[allowed])]), *cuts[k + 1 :])


def rests_to_carries(
    cuts: Sequence[int],
    carries: Sequence[bool],
    rests: NDArray[np.bool_],
    most: int,
    shortest: int,
) -> tuple[int, ...]:
    """Cuts moved away from carries, to the nearest rest and for as long as the hand rests.

    Args:
        cuts: (0, …, T) in frames.
        carries: for each segment, whether something is held in it.
        rests: (T,) whether the hand rests.
        most: frames of rest that a carry gets at most; half as many may lie between.
        shortest: frames that are left to a segment.
    """
    moved = list(cuts)
    for k in range(1, len(cuts) - 1):
        if carries[k] and not carries[k - 1]:
            into = rests[moved[k - 1] + shortest : moved[k]][::-1]
            moved[k] -= _rest(into, most)
        elif carries[k - 1] and not carries[k]:
            into = rests[moved[k] : cuts[k + 1] - shortest]
            moved[k] += _rest(into, most)
    return tuple(moved)


def _rest(ahead: NDArray[np.bool_], most: int) -> int:
    """Frames up to the end of the first rest ahead; 0 where none starts within half of ``most``."""
    found = np.flatnonzero(ahead[: most // 2 + 1])
    if not len(found):
        return 0
    rest = ahead[found[0] :][:most]
    return int(found[0]) + (len(rest) if rest.all() else int(np.argmin(rest)))


def _squares(values: Array) -> Array:
    """(N + 1,) sum of squared distances of the first n values (N, …) from their mean, for n = 0…N."""
    flat = values.reshape(len(values), -1) - values.reshape(len(values), -1).mean(axis=0)
    n = np.arange(1, len(flat) + 1)
    total = np.cumsum(flat**2, axis=0).sum(axis=1) - (np.cumsum(flat, axis=0) ** 2).sum(axis=1) / n
    return np.append(0.0, total)
