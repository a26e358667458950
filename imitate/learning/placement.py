"""Where objects are to end: what the carries of a demonstration have placed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import HAND, TABLE, Demonstration
from imitate.geometry import IDENTITY, Array, angle_between, relative, resample
from imitate.record import Sightings, TrialRecord
from imitate.settings import Learning
from imitate.skill import Segment


@dataclass(frozen=True)
class Placement:
    """Where an object is to end.

    Attributes:
        index, name: the object.
        reference: in whose frame it was last carried: an object, or the table.
        position: (3,) m, shown there.
        left: whether the hand has left it by then.
    """

    index: int
    name: str
    reference: str
    position: Array
    left: bool


def placements(demonstration: Demonstration, segments: Sequence[Segment]) -> tuple[Placement, ...]:
    """Where each object carried in ``segments`` is shown, at their end, relative to its reference object."""
    names = demonstration.object_names
    last = {name: i for i, segment in enumerate(segments) for name in segment.abstraction.carried}
    found = []
    for name, i in last.items():
        reference = segments[i].abstraction.reference
        t = demonstration.t - demonstration.t[0]
        pair = np.stack([demonstration.pose_of(reference), demonstration.pose_of(name)], axis=1)
        at, pose = resample(t, pair, [segments[-1].end])[0]
        position = relative(at, pose)[:3]
        left = i < len(segments) - 1
        found.append(Placement(names.index(name), name, reference, position, left))
    return tuple(found)


def trajectory_of(record: TrialRecord, object_names: Sequence[str], body: str) -> Array:
    """World poses (N, 7) in a trial of the hand, an object, or the table, which stays where it is."""
    if body == TABLE:
        return np.tile(IDENTITY, (record.steps, 1))
    if body == HAND:
        return record.hand_poses
    return np.asarray(record.object_poses[:, object_names.index(body)])


def displaced(
    record: TrialRecord, object_names: Sequence[str], wanted: Sequence[Placement], settings: Learning
) -> bool:
    """Whether something was off its place already when the last option of the record started."""
    began = record.option_starts[-1]
    return any(_off(record, object_names, place, began) > settings.near for place in wanted)


def misplaced(
    record: TrialRecord, object_names: Sequence[str], wanted: Sequence[Placement], settings: Learning
) -> str:
    """What is not where it was shown at a trial's end, in words; empty when everything is."""
    reasons = []
    for place in wanted:
        off = _off(record, object_names, place, -1)
        if off > settings.near:
            reasons.append(
                f"{place.name} ends {off * 1e3:.0f} mm from its place relative to {place.reference}"
            )
        elif not resting(record.object_poses[:, place.index], record.time_step, settings):
            reasons.append(f"{place.name} is still moving")
        elif place.left and record.contact_forces[-1, place.index] > 0:
            reasons.append(f"the gripper still touches {place.name}")
    return "; ".join(reasons)


def _off(record: TrialRecord, object_names: Sequence[str], place: Placement, step: int) -> float:
    # m between where an object is at a step and where it was shown, in its reference's frame.
    reference = trajectory_of(record, object_names, place.reference)[step]
    now = relative(reference, record.object_poses[step, place.index])
    return float(np.linalg.norm(now[:3] - place.position))


def unseen(seen: Sightings | None, object_names: Sequence[str], bodies: Iterable[str]) -> str:
    """Which of these bodies the camera did not see at a trial's end, in words; empty where nobody watched."""
    if seen is None:
        return ""
    hidden = {name for name, shown in zip(object_names, seen.in_sight, strict=True) if not shown}
    lost = [name for name in object_names if name in hidden.intersection(bodies)]
    return f"{' and '.join(lost)} {'were' if len(lost) > 1 else 'was'} not seen at the end" if lost else ""


def resting(poses: Array, time_step: float, settings: Learning) -> bool:
    """Whether a body's trajectory (N, 7) moved by less than a share of the tolerance in its last moments."""
    back = min(len(poses), max(1, round(settings.rest_time / time_step)))
    before, now = poses[-back], poses[-1]
    moved = float(np.linalg.norm(now[:3] - before[:3]))
    turned = float(np.rad2deg(angle_between(before, now)))
    share = settings.rest_share_seen if settings.observe_trials else settings.rest_share
    return moved < share * settings.near and turned < share * settings.near_angle
