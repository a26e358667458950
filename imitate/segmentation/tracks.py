"""What of a body's trajectory can be believed, and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import HAND, Demonstration
from imitate.geometry import Array, align_signs, angle_between, conjugate, quaternion_multiply, resample
from imitate.segmentation.outliers import outliers
from imitate.segmentation.readings import fresh, trembling
from imitate.settings import Segmentation

JUMP = 3.0
"""times the next step that a track jumps by where it was frozen before."""
STILL = 0.1
"""of ``slack``: a sensor that trembles by less may read a resting body as equal again and again."""
FEW = 10
"""readings, below which a body's noise is what its kind trembles by."""


@dataclass(frozen=True)
class Track:
    """A body's trajectory.

    Attributes:
        poses: (T, 7), of one sign along the way where they are known.
        known: (T,) which of them can be believed; one at least.
        noise: metres, standard deviation per axis of a reading.
        turn_noise: radians, likewise.
        every: seconds from one reading to the next, as a rule.
    """

    poses: Array
    known: NDArray[np.bool_]
    noise: float
    turn_noise: float
    every: float


def tracks_of(demonstration: Demonstration, settings: Segmentation) -> tuple[Track, ...]:
    """The tracks of the hand and of each object; the objects are judged by the noisiest one's sensor."""
    d = demonstration
    hand, *objects = (
        trembling(d.t[seen], d.pose_of(name)[seen])
        for name in (HAND, *d.object_names)
        for seen in [d.seen(name)]
    )
    bodies = (track_of(d.t, d.pose_of(name), settings, max(objects)) for name in d.object_names)
    return track_of(d.t, d.hand, settings, hand), *bodies


def believed(demonstration: Demonstration, tracks: tuple[Track, ...]) -> Demonstration:
    """The demonstration as its tracks are known: seven NaN elsewhere, but where next to nothing is known."""
    hand, *objects = (
        np.where(track.known[:, None], track.poses, np.nan) if track.known.sum() > 1 else given
        for track, given in zip(
            tracks, (demonstration.hand, *np.moveaxis(demonstration.objects, 1, 0)), strict=True
        )
    )
    return replace(demonstration, hand=hand, objects=np.stack(objects, axis=1))


def track_of(t: Array, poses: Array, settings: Segmentation, trembles: float = 0.0) -> Track:
    """The track of poses (T, 7), seven NaN where not seen, at seconds (T,).

    Args:
        trembles: metres per axis, how much a sensor of this kind does. If it does so at all, a pose that
            repeats a reading is none: it is taken from the readings on either side where they are within
            ``window`` of each other, else it is not known. So is an outlier.
    """
    seen = believable(poses, settings)
    read, noisy = seen.copy(), trembles > STILL * settings.slack
    if noisy:
        read[seen] = fresh(t[seen], poses[seen])
    read[read] = ~outliers(t[read], poses[read], max(noise(t[read], poses[read]), trembles), settings)
    at, readings = t[read], align_signs(poses[read])
    few = noisy and len(at) < FEW
    between = seen & ~read & _between(at, t, settings.window)
    track = poses.copy()
    track[read] = readings
    if between.any():
        track[between] = resample(at, readings, t[between])
        track[read | between] = align_signs(track[read | between])
    return Track(
        track,
        read | between,
        max(noise(at, readings), trembles if few else 0.0),
        turn_noise(at, readings),
        float(np.median(np.diff(at))) if len(at) > 1 else np.inf,
    )


def _between(at: Array, t: Array, most: float) -> NDArray[np.bool_]:
    """(T,) which times lie between two of ``at`` that are ``most`` apart at most."""
    k = np.searchsorted(at, t).clip(1, max(len(at) - 1, 1))
    if len(at) < 2:
        return np.zeros(len(t), bool)
    return np.asarray((t > at[k - 1]) & (t < at[k]) & (at[k] - at[k - 1] <= most))


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
    u = _shares(t)
    return _deviation(u, poses[1:-1, :3] - (1 - u) * poses[:-2, :3] - u * poses[2:, :3])


def turn_noise(t: Array, poses: Array) -> float:
    """Standard deviation of the noise per axis of the orientations of poses (T, 7) of one sign, radians."""
    if len(t) < 3 or not np.ptp(poses[:, 3:], axis=0).any():
        return 0.0
    u, q = _shares(t), poses[:, 3:]
    middle = (1 - u) * q[:-2] + u * q[2:]
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    return _deviation(u, 2 * quaternion_multiply(conjugate(middle), q[1:-1])[:, :3])


def _shares(t: Array) -> Array:
    """(T − 2, 1) how far on its neighbours' way each sample is, by time."""
    return np.asarray((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]


def _deviation(u: Array, off: Array) -> float:
    deviation = 1.4826 * np.median(np.abs(off) / np.sqrt(1 + (1 - u) ** 2 + u**2), axis=0)
    return float(np.sqrt(np.mean(deviation**2)))
