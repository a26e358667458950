"""What a trial's record says of one body: where it was, whether it rests at the end, whether it was seen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from imitate.demonstration import HAND, TABLE
from imitate.geometry import IDENTITY, Array, angle_between
from imitate.record import Sightings, TrialRecord
from imitate.settings import Learning


def trajectory_of(record: TrialRecord, object_names: Sequence[str], body: str) -> Array:
    """World poses (N, 7) in a trial of the hand, an object, or the table, which stays where it is."""
    if body == TABLE:
        return np.tile(IDENTITY, (record.steps, 1))
    if body == HAND:
        return record.hand_poses
    return np.asarray(record.object_poses[:, object_names.index(body)])


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
