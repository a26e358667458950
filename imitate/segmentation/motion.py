"""How bodies move: which samples can be believed, how noisy they are, and whether a body goes with the hand.

Motion is rigid: a body goes along with the hand when the point of it under the hand does, wherever its origin
lies. So a door, a lid or a drawer counts, and so does a knob, which only turns.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import (
    Array,
    align_signs,
    angle_between,
    compose,
    conjugate,
    inverse,
    normalised,
    quaternion_multiply,
    resample,
)
from imitate.settings import Segmentation

JUMP = 3.0
"""times the next step that a track jumps by where it was frozen before."""


def going_along(t: Array, hand: Array, body: Array, times: Array, settings: Segmentation) -> Array:
    """What each frame says for a body to move with the hand rather than stand still, in nats.

    Over a window, the hand's displacement is compared with that of the body's point under it. No more speaks
    for moving along than the hand's own displacement: nothing where it rests, whatever the body does.

    Args:
        t: (S,) seconds at which both were seen.
        hand, body: (S, 7) poses at these times.
        times: (T,) seconds of the frames, evenly spaced.

    Returns:
        (T,) each frame's share of the window centred on it; a whole window says ``clip`` at most. Zeros where
        the two were hardly seen together (S < 2).
    """
    if len(t) < 2:
        return np.zeros(len(times))
    step = times[1] - times[0]
    first, last = _windows(len(times), max(1, round(settings.window / step)))
    turns = bool(np.ptp(body[:, 3:], axis=0).any())
    count = _samples(t, settings.window / 3)
    shaking = 2 / count * (noise(t, hand) ** 2 + noise(t, body) ** 2)
    turning = 2 / count * turn_noise(t, body) ** 2
    wavering = turning + 2 / count * turn_noise(t, hand) ** 2
    t, hand, body = _mean(t, count), _mean_pose(hand, count), _mean_pose(body, count)
    h, o = resample(t, hand, times), resample(t, body, times)
    start, end = h[first], h[last]
    carried = compose(compose(o[last], inverse(o[first])), start)
    lever = np.linalg.norm(start[:, :3] - o[first, :3], axis=1)
    gain = _gain(*(np.linalg.norm(a[:, :3] - b[:, :3], axis=1) for a, b in _pairs(carried, start, end)))
    said = gain / (shaking + lever**2 * turning + settings.slack**2)
    if turns:
        gain = _gain(*(angle_between(a, b) for a, b in _pairs(carried, start, end)))
        said += gain / (wavering + (settings.slack / settings.hand_radius) ** 2)
    share = step / settings.window
    return np.asarray(np.clip(said / 2, -settings.clip, settings.clip) * share)


def believable(poses: Array, settings: Segmentation) -> NDArray[np.bool_]:
    """(T,) which samples of poses (T, 7) were seen and are no frozen repetition of an earlier one.

    A lost track often repeats its last pose and then jumps, by more than ``slack``. A body that rests and then
    sets off does not jump: its next step is as long as its first.
    """
    seen = np.flatnonzero(~np.isnan(poses[:, 0]))
    path = poses[seen]
    same = np.append(False, (path[1:] == path[:-1]).all(axis=1))
    shifts = np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1)
    steps = np.hypot(shifts, settings.hand_radius * angle_between(path[1:], path[:-1]))
    after = np.append(steps[1:], 0.0)
    jumps = np.append((steps > settings.slack) & (steps > JUMP * after), False)  # from a sample to its next
    ends = np.flatnonzero(~np.append(same[1:], False))  # the last sample of each run of equal ones
    lost = same & jumps[ends[np.searchsorted(ends, np.arange(len(path)))]]
    mask = np.zeros(len(poses), bool)
    mask[seen[~lost]] = True
    return mask


def noise(t: Array, poses: Array) -> float:
    """Standard deviation of the noise per axis of positions (T, 3) or poses (T, 7), metres.

    From the median absolute deviation of each frame from the straight line between its neighbours, which
    constant velocity and irregular times leave at zero.
    """
    return _spread(t, lambda u: poses[1:-1, :3] - (1 - u) * poses[:-2, :3] - u * poses[2:, :3])


def turn_noise(t: Array, poses: Array) -> float:
    """Standard deviation of the noise per axis of the orientations of poses (T, 7), radians."""
    q = align_signs(poses)[:, 3:]

    def off(u: Array) -> Array:
        between = (1 - u) * q[:-2] + u * q[2:]
        between /= np.linalg.norm(between, axis=1, keepdims=True)
        return 2 * quaternion_multiply(conjugate(between), q[1:-1])[:, :3]

    return _spread(t, off)


def _spread(t: Array, off: Callable[[Array], Array]) -> float:
    if len(t) < 3:
        return 0.0
    u = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    deviation = 1.4826 * np.median(np.abs(off(u)) / np.sqrt(1 + (1 - u) ** 2 + u**2), axis=0)
    return float(np.sqrt(np.mean(deviation**2)))


def _samples(t: Array, seconds: float) -> int:
    """How many samples one may average over that time; odd, unless there are no more."""
    return min(2 * int(seconds / np.median(np.diff(t)) / 2) + 1, len(t))


def _mean(values: Array, count: int) -> Array:
    """Means of each ``count`` values (S, ...) in a row, S + 1 − count of them."""
    total = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    return np.asarray((total[count:] - total[:-count]) / count)


def _mean_pose(poses: Array, count: int) -> Array:
    return normalised(_mean(align_signs(poses), count))


def _windows(frames: int, width: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """First and last frame of the window centred on each frame; shifted or cut at the ends."""
    last = np.minimum(np.maximum(np.arange(frames) - width // 2, 0) + width, frames - 1)
    return np.maximum(last - width, 0), last


def _pairs(carried: Array, start: Array, end: Array) -> tuple[tuple[Array, Array], ...]:
    return (carried, start), (carried, end), (end, start)


def _gain(still: Array, along: Array, own: Array) -> Array:
    """How much better "along" explains a displacement than "still": at most by the hand's ``own``."""
    return np.asarray(np.minimum(still**2 - along**2, own**2))
