"""The verdict on a trial: a pure function of what was shown (`places`) and of the trial's record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imitate.demonstration import TABLE
from imitate.geometry import IDENTITY, Array, angle_between, compose, quaternion_multiply, relative
from imitate.learning.bodies import resting, trajectory_of
from imitate.learning.places import Place
from imitate.perception.symmetry import nearest_alike
from imitate.record import TrialRecord
from imitate.settings import Learning
from imitate.skill import Miss


def verdict(
    asked: Sequence[Place], record: TrialRecord, object_names: Sequence[str], settings: Learning
) -> tuple[Miss, ...]:
    """What of the places asked for is not so at a trial's end; empty where the task is done."""
    found = (_miss(place, record, object_names, settings) for place in asked)
    return tuple(miss for miss in found if miss)


def displaced(asked: Sequence[Place], record: TrialRecord, object_names: Sequence[str]) -> bool:
    """Whether something was off its place already when the last option of the record started."""
    began = record.option_starts[-1]
    return any(_off(place, record, object_names, began)[0] > place.near for place in asked)


def _miss(place: Place, record: TrialRecord, object_names: Sequence[str], settings: Learning) -> Miss | None:
    off, angle = _off(place, record, object_names, -1)
    words = ""
    if off > place.near or angle > place.near_angle:
        words = _off_in_words(place, off, angle, settings)
    elif _hardly_moved(place, record, object_names):
        words = f"{place.name} was hardly moved"
    elif place.kind != "still":
        if not resting(record.object_poses[:, place.index], record.time_step, settings):
            words = f"{place.name} is still moving"
        elif place.left and record.contact_forces[-1, place.index] > 0:
            words = f"the gripper still touches {place.name}"
    return Miss("place", words, place.name, off, angle) if words else None


def _off(place: Place, record: TrialRecord, object_names: Sequence[str], step: int) -> tuple[float, float]:
    # m and rad between where an object is at a step and where it is to end.
    wanted, pose = _wanted(place, record, object_names, step), record.object_poses[step, place.index]
    if place.alike is not None:
        pose = nearest_alike(pose, place.alike, wanted)
    return float(np.linalg.norm(pose[:3] - wanted[:3])), float(angle_between(pose, wanted))


def _wanted(place: Place, record: TrialRecord, object_names: Sequence[str], step: int) -> Array:
    # (7,) world pose in which the object is to be at a step.
    if place.reference:
        return compose(trajectory_of(record, object_names, place.reference)[step], place.pose)
    start = record.start.objects[place.index]
    turned = quaternion_multiply(place.pose[3:], start[3:])
    return np.concatenate([start[:3] + place.pose[:3], turned])


def _hardly_moved(place: Place, record: TrialRecord, object_names: Sequence[str]) -> bool:
    # Whether the object never left where the trial began by as much as it is asked to.
    if not (place.least or place.least_angle):
        return False
    reference = place.reference or TABLE
    at_first = IDENTITY if reference == TABLE else record.start.objects[object_names.index(reference)]
    start = relative(at_first, record.start.objects[place.index])
    path = relative(trajectory_of(record, object_names, reference), record.object_poses[:, place.index])
    far = float(np.linalg.norm(path[:, :3] - start[:3], axis=1).max())
    return far < place.least or float(angle_between(path, start).max()) < place.least_angle


def _off_in_words(place: Place, off: float, angle: float, settings: Learning) -> str:
    far = off > place.near
    if place.kind == "still":
        how = f"moved by {off * 1e3:.0f} mm" if far else f"turned by {np.rad2deg(angle):.0f}°"
        return f"{place.name} was {how}, and was shown to stay"
    amount = f"{off * 1e3:.0f} mm" if far else f"turned by {np.rad2deg(angle):.0f}°"
    where = (
        f"its place relative to {place.reference}" if place.reference else "where it was shown to be moved"
    )
    strict = far and place.near < settings.near
    allowed = f" ({place.near * 1e3:.0f} mm allowed, half of what was shown)" if strict else ""
    return f"{place.name} ends {amount} from {where}{allowed}"
