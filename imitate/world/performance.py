"""What the virtual demonstrator performs: a recorded motion, settled, with a retreat and an opening hand."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imitate.demonstration import Demonstration, in_table_frame
from imitate.geometry import Array, align_signs, conjugate, from_yaw, read_only, relative, resample, rotate
from imitate.skill import Segment

OPEN = 0.08
"""m between the fingers when nothing is held."""
CLEARANCE = 0.001
"""m by which the fingers stand off the block that they hold."""
REST, WITHDRAW, STAND = 0.3, 1.2, 0.3
"""s, the retreat: the hand rests opened, withdraws, stands still."""
RETREAT = np.array([-0.04, 0.0, 0.113])
"""m, the way that the hand withdraws: 12 cm, up and back."""
WALL = 0.008
"""m, the thickness of an open box's walls and floor."""
_STEP = 0.01
_HELD = 0.003


@dataclass(frozen=True)
class Performance:
    """A demonstration in the table's frame, and what its poses do not say.

    Attributes:
        opening: (T,) metres between the fingers' surfaces.
        segments: what a right segmentation is; empty where that is not known.
        hollow: names of the objects that are open boxes with walls of `WALL`.
    """

    demonstration: Demonstration
    opening: Array
    segments: tuple[Segment, ...] = ()
    hollow: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "opening", read_only(self.opening))

    def at(self, t: Array) -> Performance:
        """The same performance at other times (S,)."""
        d = self.demonstration
        sampled = replace(d, t=t, hand=resample(d.t, d.hand, t), objects=resample(d.t, d.objects, t))
        return replace(self, demonstration=sampled, opening=np.interp(t, d.t, self.opening))


def perform(demonstration: Demonstration) -> Performance:
    """``demonstration`` in the table's frame, with everything at rest in the end and a retreat added."""
    d = in_table_frame(demonstration)
    hand, objects = align_signs(d.hand), np.array(d.objects)
    count = round((REST + WITHDRAW + STAND) / _STEP)
    later = np.linspace(_STEP, count * _STEP, count)
    withdrawn = np.repeat(hand[-1:], count, axis=0)
    withdrawn[:, :3] += minimum_jerk((later - REST) / WITHDRAW)[:, None] * RETREAT
    settled = _settled(d)
    ends = np.stack([objects[-1], settled])
    settling = resample([0, REST / 2], ends, later)
    whole = replace(
        d,
        t=np.concatenate([d.t, d.t[-1] + later]),
        hand=np.concatenate([hand, withdrawn]),
        objects=np.concatenate([objects, settling]),
    )
    return Performance(whole, _opening(whole))


def minimum_jerk(u: Array) -> Array:
    """The share of the way after the share ``u`` of the time, by least jerk (Flash & Hogan 1985)."""
    u = np.clip(u, 0, 1)
    return np.asarray(u**3 * (10 - 15 * u + 6 * u**2))


def _settled(d: Demonstration) -> Array:
    """(K, 7) the objects' last poses, lying flat on the highest object under them, or on the table."""
    poses = np.array(d.objects[-1])
    tops: list[tuple[int, float]] = []
    for k in np.argsort(poses[:, 2]):
        size, upright = d.object_sizes[k], rotate(poses[k, 3:], [0, 0, 1.0])[2] > 0.99
        if np.any(np.isnan(size)) or not upright:
            continue
        under = [top for j, top in tops if _over(poses[j], d.object_sizes[j], poses[k])]
        poses[k, 2] = max(under, default=0.0) + size[2] / 2
        x, y, _ = rotate(poses[k, 3:], [1.0, 0, 0])
        poses[k] = from_yaw(poses[k, :3], np.arctan2(y, x))
        tops.append((int(k), poses[k, 2] + size[2] / 2))
    return poses


def _over(below: Array, size: Array, above: Array) -> bool:
    return bool(np.all(np.abs(relative(below, above)[:2]) < size[:2] / 2))


def _opening(d: Demonstration) -> Array:
    """(T,) metres: just wider than a block while it is held, opening and closing within 0.15 s around it."""
    opening = np.full(len(d.t), OPEN)
    for k in range(len(d.object_names)):
        held = _held(d, k)
        if held.any():
            start, end = d.t[held][[0, -1]]
            along = rotate(conjugate(d.objects[:, k, 3:]), rotate(d.hand[:, 3:], [0, 1.0, 0]))
            width = np.abs(along) @ d.object_sizes[k] + CLEARANCE
            away = np.clip(np.maximum(start - d.t, d.t - end) / 0.15, 0, 1)
            opening = np.minimum(opening, width + away * (OPEN - width))
    return opening


def _held(d: Demonstration, k: int) -> Array:
    """(T,) whether the hand holds object k: it lies in the hand as when it was farthest from its start."""
    moved = np.linalg.norm(d.objects[:, k, :3] - d.objects[0, k, :3], axis=1)
    lifted = d.objects[:, k, 2] - d.objects[0, k, 2] > 0.03
    speed = np.linalg.norm(np.gradient(d.objects[:, k, :3], d.t, axis=0), axis=1)
    carried = lifted & (speed > 0.02) & (moved > 0.03)
    if not carried.any() or np.any(np.isnan(d.object_sizes[k])):
        return np.zeros(len(d.t), bool)
    inside = relative(d.hand, d.objects[:, k])[:, :3]
    apart = np.linalg.norm(inside - np.median(inside[carried], axis=0), axis=1)
    return np.asarray(apart < _HELD)
