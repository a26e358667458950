"""Whether a body goes along with the hand.

Motion is rigid: a body goes along when the point of it under the hand does, wherever its origin lies. So a
door, a lid or a drawer counts, and so does a knob, which only turns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, conjugate, quaternion_multiply, rotate
from imitate.segmentation.tracks import Track
from imitate.settings import Segmentation

TINY = 1e-300
"""keeps a hand that does not move at all from dividing by zero."""


def going_along(t: Array, hand: Track, body: Track, times: Array, settings: Segmentation) -> Array:
    """What each frame says for a body to move with the hand rather than stand still, in nats.

    A third of the window tells quick changes apart; as far as it is not sure, the whole window speaks.

    Args:
        t: (S,) seconds of the tracks' samples.
        times: (T,) seconds of the frames, evenly spaced.

    Returns:
        (T,) each frame's share of the window centred on it; a whole window says ``clip`` at most. Zeros where
        the two were hardly seen together.
    """
    both = hand.known & body.known
    if both.sum() < 2:
        return np.zeros(len(times))
    t, paths = t[both], np.hstack([hand.poses[both], body.poses[both]])
    short, whole = (
        _over(window, t, paths, hand, body, times, settings)
        for window in (settings.window / 3, settings.window)
    )
    share = (times[1] - times[0]) / settings.window
    return np.asarray(share * (short + (1 - np.abs(short) / settings.clip) * whole))


def _over(
    window: float, t: Array, paths: Array, hand: Track, body: Track, times: Array, settings: Segmentation
) -> Array:
    """What the window centred on each frame says, (T,) nats, at most ``clip``.

    The hand's displacement is compared with that of the body's point under it. No more speaks for going
    along than the hand's own displacement: nothing where it rests, whatever the body does.

    Args:
        paths: (S, 14) poses of the hand and the body.
    """
    first, last = _windows(len(times), max(1, round(window / (times[1] - times[0]))))
    count = min(2 * int(window / 6 / np.median(np.diff(t))) + 1, len(t))
    at = _interpolated(_mean(t, count), _mean(paths, count), times)
    h, o = at[:, :3], at[:, 7:10]
    own, arm = h[last] - h[first], h[first] - o[first]
    moved = o[last] - o[first]
    shaking = 2 / count * (hand.noise**2 + body.noise**2) + settings.slack**2
    rest = 6 / count * hand.noise**2
    if not np.ptp(paths[:, 10:], axis=0).any():
        said = _gain(moved, own, rest) / shaking
        return np.asarray(np.clip(said / 2, -settings.clip, settings.clip))
    turned, turn = (_turn(_unit(at[:, k : k + 4]), first, last) for k in (3, 10))
    turning = 2 / count * body.turn_noise**2
    said = _gain(moved + rotate(turn, arm) - arm, own, rest) / (shaking + np.sum(arm**2, axis=1) * turning)
    wavering = 2 / count * hand.turn_noise**2 + turning + (settings.slack / settings.hand_radius) ** 2
    gain = _angle(turn[:, 3]) ** 2 - _angle(np.sum(turn * turned, axis=1)) ** 2
    said += _bounded(gain, _angle(turned[:, 3]) ** 2, 6 / count * hand.turn_noise**2) / wavering
    return np.asarray(np.clip(said / 2, -settings.clip, settings.clip))


def _gain(moved: Array, own: Array, rest: float) -> Array:
    """How much better a displacement (T, 3) fits the hand's ``own`` than none, m²."""
    squared = np.sum(own**2, axis=1)
    return _bounded(2 * np.sum(moved * own, axis=1) - squared, squared, rest)


def _bounded(gain: Array, own: Array, rest: float) -> Array:
    """A gain, at most the hand's own squared displacement, and none where that is ``rest``, all noise.

    Else a hand at rest would speak against what it holds, and a long pause would end a carry.
    """
    return np.asarray(np.minimum(gain, own) * np.maximum(0, 1 - rest / np.maximum(own, TINY)))


def _turn(q: Array, first: NDArray[np.int_], last: NDArray[np.int_]) -> Array:
    return quaternion_multiply(q[last], conjugate(q[first]))


def _angle(cosine: Array) -> Array:
    """Radians of turns by the cosine of half of them."""
    return np.asarray(2 * np.arccos(np.minimum(np.abs(cosine), 1)))


def _unit(q: Array) -> Array:
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def _mean(values: Array, count: int) -> Array:
    """Means of each ``count`` values (S, ...) in a row, S + 1 − count of them."""
    if count == 1:
        return values
    total = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    return np.asarray((total[count:] - total[:-count]) / count)


def _interpolated(t: Array, values: Array, at: Array) -> Array:
    """Values (S, N) at other times, linearly; the first and last beyond the ends."""
    if len(t) == 1:
        return np.repeat(values, len(at), axis=0)
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    u = np.clip((at - t[k]) / (t[k + 1] - t[k]), 0, 1)[:, None]
    return np.asarray(values[k] + u * (values[k + 1] - values[k]))


def _windows(frames: int, width: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """First and last frame of the window centred on each frame; shifted or cut at the ends."""
    last = np.minimum(np.maximum(np.arange(frames) - width // 2, 0) + width, frames - 1)
    return np.maximum(last - width, 0), last
