"""What each object is to do, derived from the demonstration alone: by this a task is judged.

What learning states, accepts or gives up enters nowhere: a place follows from the demonstration and from its
segments as they were found or as the operator decided.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.signal import medfilt

from imitate.demonstration import Demonstration
from imitate.geometry import (
    IDENTITY,
    Array,
    angle_between,
    conjugate,
    quaternion_multiply,
    read_only,
    relative,
)
from imitate.perception.symmetry import nearest_alike
from imitate.segmentation.tracks import noise, turn_noise
from imitate.settings import Learning
from imitate.skill import Segment

MOVED = 0.005
"""m, and m at the surface of what turns, above which an object was moved, where its track has no noise."""
_NOISES = 4.0
"""standard deviations of a track's noise that are no motion."""
_MOMENT = 0.1
"""s at either end of a track whose most central pose counts, so that one wrong frame does not."""
_PASSING = 0.3
"""s: what lasts for less than half of it is a wrong frame and no excursion."""
_LEVER = 0.05
"""m from its origin to the surface of an object of unknown size: half a hand's breadth."""


@dataclass(frozen=True)
class Place:
    """What an object is to do.

    Attributes:
        index, name: the object.
        kind: "carried" by the hand, "moved" by something else, or "still": left alone.
        reference: in whose frame its ``pose`` is: an object's or the table's, where it was carried; empty:
            its own start's.
        pose: (7,) where it is to end there; from its own start, its displacement and turn in the world.
        near: m that it may be off.
        near_angle: rad that it may be turned from there; ∞ where turning is not what was shown.
        least, least_angle: m and rad by which it has to have been moved on the way; 0: none.
        left: whether the hand has left it by then.
        alike: its size (3,) m where turned poses that look the same are the same; None: they are not.
    """

    index: int
    name: str
    kind: Literal["carried", "moved", "still"]
    reference: str
    pose: Array
    near: float
    near_angle: float
    least: float
    least_angle: float
    left: bool
    alike: Array | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", read_only(self.pose))


def places(
    demonstration: Demonstration, segments: Sequence[Segment], settings: Learning
) -> tuple[Place, ...]:
    """What each object is to do, in the demonstration's order.

    What was carried is to end where it was shown, relative to what it was last carried in relation to. What
    was moved otherwise is to be displaced as shown, and all else is to stay. Where something was carried,
    what was moved by less than ``near`` beside it was knocked, and need not be again. The tolerance is the
    smaller of ``near`` and half of what was shown, and of ``near_angle`` likewise, so that doing nothing does
    not pass.

    Args:
        demonstration: every pose known.
        segments: as found, or as the operator decided; the places are those at the end of the last.
        settings: of learning.
    """
    count = len(demonstration.object_names)
    shown = [_shown(demonstration, segments, k, settings) for k in range(count)]
    carried = any(one.carried and one.happened for one in shown)
    return tuple(_place(one, carried, settings) for one in shown)


def asked_for(asked: Sequence[Place]) -> set[str]:
    """Whose poses have to be known at a trial's end: what is not left alone, and what its place is by."""
    return {body for p in asked if p.kind != "still" for body in (p.name, p.reference) if body}


@dataclass(frozen=True)
class _Shown:
    # What one object did up to the end of the last segment.
    index: int
    name: str
    carried: bool
    reference: str  # by which it was carried; empty: it was not
    pose: Array  # as in Place
    distance: float  # m from the first pose to the last
    angle: float  # rad, likewise
    excursion: float  # m that it was from its first pose at most; 0 where that is noise
    moved: bool  # from the first pose to the last, by more than noise
    turned: bool  # likewise, and by more at its surface than it was moved
    happened: bool  # whether it did anything
    left: bool
    alike: Array | None


def _shown(d: Demonstration, segments: Sequence[Segment], k: int, settings: Learning) -> _Shown:
    name, size = d.object_names[k], d.object_sizes[k]
    carries = [i for i, s in enumerate(segments) if name in s.abstraction.carried]
    reference = segments[carries[-1]].abstraction.reference if carries else ""
    t = d.t - d.t[0]
    until = t <= segments[-1].end + 1e-9
    t, own = t[until], d.objects[until, k]
    path = relative(d.pose_of(reference)[until], own) if carries else own
    first, last = _ends(t, path)
    alike = size if name in settings.symmetric else None
    angle = float(angle_between(last if alike is None else nearest_alike(last, alike, first), first))
    distance, travelled = (float(np.linalg.norm(b[:3] - a[:3])) for a, b in ((first, last), _ends(t, own)))
    least = max(MOVED, _NOISES * noise(t, own))
    lever = _LEVER if np.isnan(size).any() else float(np.linalg.norm(size)) / 2
    moved = distance > least
    turned = angle > max(MOVED / lever, _NOISES * turn_noise(t, own)) and angle * lever > distance
    excursion = _excursion(t, path, first)
    excursion = excursion if excursion > least else 0.0
    return _Shown(
        index=k,
        name=name,
        carried=bool(carries),
        reference=reference,
        pose=last if carries else _motion(first, last),
        distance=distance,
        angle=angle,
        excursion=excursion,
        moved=moved,
        turned=turned,
        happened=moved or turned or travelled > least or bool(carries and excursion),
        left=bool(carries) and carries[-1] < len(segments) - 1,
        alike=alike,
    )


def _place(shown: _Shown, something_carried: bool, settings: Learning) -> Place:
    near, near_angle = settings.near, float(np.deg2rad(settings.near_angle))
    knocked = something_carried and not shown.carried and shown.distance < near and not shown.turned
    if knocked or not shown.happened:
        still = IDENTITY, near, near_angle, 0.0, 0.0, False
        return Place(shown.index, shown.name, "still", "", *still, shown.alike)
    near = min(near, shown.distance / 2) if shown.moved else near
    near_angle = min(near_angle, shown.angle / 2)
    return Place(
        index=shown.index,
        name=shown.name,
        kind="carried" if shown.carried else "moved",
        reference=shown.reference,
        pose=shown.pose,
        near=near,
        near_angle=near_angle if shown.turned else np.inf,
        least=near / 2 if shown.moved else min(near, shown.excursion / 2) if shown.carried else 0.0,
        least_angle=near_angle / 2 if shown.turned else 0.0,
        left=shown.left,
        alike=shown.alike,
    )


def _ends(t: Array, path: Array) -> tuple[Array, Array]:
    # The first and the last pose (7,) of a path (T, 7).
    return _central(path[t <= t[0] + _MOMENT]), _central(path[t >= t[-1] - _MOMENT])


def _central(poses: Array) -> Array:
    # (7,) that of some poses (N, 7) whose position is nearest to all the others.
    apart = np.linalg.norm(poses[:, None, :3] - poses[None, :, :3], axis=-1)
    return np.asarray(poses[int(np.argmin(apart.sum(axis=0)))])


def _motion(first: Array, last: Array) -> Array:
    # (7,) displacement and turn in the world from one pose to another.
    turn = quaternion_multiply(last[3:], conjugate(first[3:]))
    return np.concatenate([last[:3] - first[:3], turn])


def _excursion(t: Array, path: Array, first: Array) -> float:
    # m that a path (T, 7) goes from its first pose at most, for longer than a wrong frame lasts.
    apart = np.linalg.norm(path[:, :3] - first[:3], axis=1)
    frames = round(_PASSING / float(np.median(np.diff(t)))) if len(t) > 1 else 1
    window = max(1, (min(frames, len(apart)) - 1) | 1)
    return float(medfilt(apart, window if window <= len(apart) else 1).max())
