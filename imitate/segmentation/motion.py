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
    windows = settings.window / 3, settings.window, max(settings.long_window, settings.window)
    short, whole, long = (_over(window, t, paths, hand, body, times, settings) for window in windows)
    noisy = max(0.0, 1 - settings.slack**2 / max(hand.noise**2 + body.noise**2, TINY))
    whole = whole + noisy * _unsure(whole, settings) * long * settings.window / windows[-1]
    return np.asarray((times[1] - times[0]) / settings.window * (short + _unsure(short, settings) * whole))


def _unsure(said: Array, settings: Segmentation) -> Array:
    return 1 - np.abs(said) / settings.clip


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
    count = _averaged(window, float(np.median(np.diff(t))), len(t))
    counts = [min(count, _averaged(window, track.every, len(t))) for track in (hand, body)]
    shares = _shares_of_gaps(window, t, times[first] / 2 + times[last] / 2, max(hand.every, body.every))
    at = _interpolated(_mean(t, count), _mean(paths, count), times)
    h, o = at[:, :3], at[:, 7:10]
    own, arm = h[last] - h[first], h[first] - o[first]
    moved = o[last] - o[first]
    hands, bodies = (2 / n * track.noise**2 * shares for n, track in zip(counts, (hand, body), strict=True))
    shaking, rest = hands + bodies + settings.slack**2, 3 * shares * hands
    if not np.ptp(paths[:, 10:], axis=0).any():
        said = _gain(moved, own, rest) / shaking
        return np.asarray(np.clip(said / 2, -settings.clip, settings.clip))
    turned, turn = (_turn(_unit(at[:, k : k + 4]), first, last) for k in (3, 10))
    hands, bodies = (
        2 / n * track.turn_noise**2 * shares for n, track in zip(counts, (hand, body), strict=True)
    )
    said = _gain(moved + rotate(turn, arm) - arm, own, rest) / (shaking + np.sum(arm**2, axis=1) * bodies)
    wavering = hands + bodies + (settings.slack / settings.hand_radius) ** 2
    gain = _angle(turn[:, 3]) ** 2 - _angle(np.sum(turn * turned, axis=1)) ** 2
    said += _bounded(gain, _angle(turned[:, 3]) ** 2, 3 * shares * hands) / wavering
    return np.asarray(np.clip(said / 2, -settings.clip, settings.clip))


def _shares_of_gaps(window: float, t: Array, middles: Array, every: float) -> Array:
    """(T,) the share that each window has of the gap between readings in which it lies; at most 1.

    All the windows in a gap know no more than the two readings at its ends: each has its share of that.
    """
    k = np.searchsorted(t, middles, side="right").clip(1, len(t) - 1)
    return np.asarray(np.minimum(1.0, window / np.maximum(t[k] - t[k - 1], every)))


def _averaged(window: float, every: float, most: int) -> int:
    """How many samples, one in ``every`` seconds, are averaged at either end of a window."""
    return min(2 * int(window / 6 / every) + 1, most)


def _gain(moved: Array, own: Array, rest: Array) -> Array:
    """How much better a displacement (T, 3) fits the hand's ``own`` than none, m²."""
    squared = np.sum(own**2, axis=1)
    return _bounded(2 * np.sum(moved * own, axis=1) - squared, squared, rest)


def _bounded(gain: Array, own: Array, rest: Array) -> Array:
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
