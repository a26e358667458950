"""What of a body's trajectory can be believed, and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, align_signs, angle_between, conjugate, quaternion_multiply
from imitate.settings import Segmentation

JUMP = 3.0
"""times the next step that a track jumps by where it was frozen before."""


@dataclass(frozen=True)
class Track:
    """A body's trajectory.

    Attributes:
        poses: (T, 7), of one sign along the way where they are known.
        known: (T,) which of them can be believed; one at least.
        noise: metres, standard deviation per axis.
        turn_noise: radians, likewise.
    """

    poses: Array
    known: NDArray[np.bool_]
    noise: float
    turn_noise: float


def track_of(t: Array, poses: Array, settings: Segmentation) -> Track:
    """The track of poses (T, 7), seven NaN where not seen, at seconds (T,)."""
    known = believable(poses, settings)
    aligned = poses.copy()
    aligned[known] = align_signs(poses[known])
    t, seen = t[known], aligned[known]
    return Track(aligned, known, noise(t, seen), turn_noise(t, seen))


def believable(poses: Array, settings: Segmentation) -> NDArray[np.bool_]:
    """(T,) which samples of poses (T, 7) were seen and are no frozen repetition of an earlier one.

    A lost track often repeats its last pose and then jumps, by more than ``slack``. A body that rests and
    then sets off does not jump: its next step is as long as its first.
    """
    seen = np.flatnonzero(~np.isnan(poses[:, 0]))
    path = poses[seen]
    same = np.append(False, (path[1:] == path[:-1]).all(axis=1))
    mask = np.zeros(len(poses), bool)
    mask[seen] = True
    if same.any():
        shifts = np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1)
        steps = np.hypot(shifts, settings.hand_radius * angle_between(path[1:], path[:-1]))
        after = np.append(steps[1:], 0.0)
        jumps = np.append((steps > settings.slack) & (steps > JUMP * after), False)
        ends = np.flatnonzero(~np.append(same[1:], False))  # the last sample of each run of equal ones
        mask[seen] = ~(same & jumps[ends[np.searchsorted(ends, np.arange(len(path)))]])
    return mask


def noise(t: Array, poses: Array) -> float:
    """Standard deviation of the noise per axis of positions (T, 3) or poses (T, 7), metres.

    From the median absolute deviation of each frame from the straight line between its neighbours, which
    constant velocity and irregular times leave at zero.
    """
    if len(t) < 3:
        return 0.0
    u = _between(t)
    return _deviation(u, poses[1:-1, :3] - (1 - u) * poses[:-2, :3] - u * poses[2:, :3])


def turn_noise(t: Array, poses: Array) -> float:
    """Standard deviation of the noise per axis of the orientations of poses (T, 7) of one sign, radians."""
    if len(t) < 3 or not np.ptp(poses[:, 3:], axis=0).any():
        return 0.0
    u, q = _between(t), poses[:, 3:]
    middle = (1 - u) * q[:-2] + u * q[2:]
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    return _deviation(u, 2 * quaternion_multiply(conjugate(middle), q[1:-1])[:, :3])


def _between(t: Array) -> Array:
    return np.asarray((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]


def _deviation(u: Array, off: Array) -> float:
    deviation = 1.4826 * np.median(np.abs(off) / np.sqrt(1 + (1 - u) ** 2 + u**2), axis=0)
    return float(np.sqrt(np.mean(deviation**2)))
