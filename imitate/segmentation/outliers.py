"""Samples at which a body was seen far from where it was just before and after: a tag taken for another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, angle_between
from imitate.settings import Segmentation

FAR = 6.0
"""times the noise by which a sample is off, at least, before it is an outlier."""
LEAST = 10.0
"""times the slack, likewise: what is let go falls by less in a frame."""
JUMP = 3.0
"""times the usual speed nearby, likewise."""
NEARBY = 7
"""steps before and after that tell the usual one."""


def outliers(t: Array, poses: Array, noise: float, settings: Segmentation) -> NDArray[np.bool_]:
    """(T,) which samples of poses (T, 7) are off for less than ``window``, with the body back where it was.

    What moves passes through the places between. A body that is gone at once and is back at once, each by far
    more than noise and than its usual step, did not move; nor one that is so at the first or last samples.

    Args:
        t: (T,) seconds.
        noise: metres, of a sample per axis; turns count by ``hand_radius``.
    """
    off = np.zeros(len(t), bool)
    if len(t) < 3:
        return off
    steps = _apart(poses[1:], poses[:-1], settings)
    took = np.diff(t)
    limits = np.maximum(max(FAR * noise, LEAST * settings.slack), JUMP * took * _usual(steps / took))
    at_once = (steps > limits) & (took < settings.window)
    back = 0
    for k in np.flatnonzero(at_once).tolist():
        if k < back:
            continue
        end = int(np.searchsorted(t, t[k] + settings.window, side="right"))
        near = k + 1 + np.flatnonzero(_apart(poses[k + 1 : end + 1], poses[k], settings) <= limits[k])
        if len(near):
            back = int(near[0]) if at_once[near[0] - 1] else 0
            off[k + 1 : back] = True
        elif t[k] - t[0] < settings.window:
            off[: k + 1] = True
        elif end == len(t):
            off[k + 1 :] = True
    return off


def _usual(speeds: Array) -> Array:
    """(T − 1,) the median of the speeds within ``NEARBY`` steps of each."""
    padded = np.pad(speeds, NEARBY, mode="reflect" if len(speeds) > NEARBY else "edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * NEARBY + 1), axis=1))


def _apart(one: Array, other: Array, settings: Segmentation) -> Array:
    """Metres between poses (…, 7), turns counted by ``hand_radius``."""
    return np.asarray(
        np.hypot(
            np.linalg.norm(one[..., :3] - other[..., :3], axis=-1),
            settings.hand_radius * angle_between(one, other),
        )
    )
