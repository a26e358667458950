"""A scene and its trials as Rerun's entities, by columns: a whole trial in a few calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array
from imitate.record import SceneSpec, Sightings, TrialRecord
from imitate.world.skeleton import Skeleton

if TYPE_CHECKING:
    import rerun as rr

_AXIS = 0.06
"""m, length of the axes drawn at the hand."""
_ARM = 0.025
"""m, radius of the arm's line."""
_ARM_RATE = 30
"""times a second that it is drawn."""


def draw_scene(recording: rr.RecordingStream, scene: SceneSpec) -> None:
    """What stays as it is: axes, boxes of the objects' sizes, colours and names of curves."""
    import rerun as rr

    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    colours = [[230, 70, 70], [70, 190, 90], [80, 120, 235]]
    axes = rr.Arrows3D(vectors=np.eye(3) * _AXIS, colors=colours)
    for root in ("world", "demonstration", "seen"):
        if root != "seen":
            recording.log(f"{root}/hand", axes, static=True)
        for name, size in zip(scene.object_names, scene.object_sizes, strict=True):
            if not np.isnan(size).any():
                box = rr.Boxes3D(half_sizes=[size / 2], labels=[name])
                recording.log(f"{root}/{entity_of(name)}", box, static=True)
    arm = rr.LineStrips3D.from_fields(radii=[_ARM], colors=[[200, 200, 205]])
    recording.log("world/arm", arm, static=True)
    joints = [f"joint {j}" for j in range(len(scene.home))]
    for entity in ("robot/positions", "robot/velocities", "robot/commands"):
        recording.log(entity, rr.SeriesLines(names=joints), static=True)


def send_record(
    recording: rr.RecordingStream, record: TrialRecord, names: Sequence[str], start: float
) -> None:
    """Every step of a trial that began at ``start`` (s)."""
    clock = clock_of(start + (np.arange(record.steps) + 1) * record.time_step)
    send_poses(recording, "world/hand", clock, record.hand_poses)
    for k, name in enumerate(names):
        send_poses(recording, f"world/{entity_of(name)}", clock, record.object_poses[:, k])
        _send_curves(recording, f"contact/{_escaped(name)}", clock, record.contact_forces[:, k : k + 1])
    _send_curves(recording, "robot/positions", clock, record.joint_positions)
    _send_curves(recording, "robot/velocities", clock, record.joint_velocities)
    ticks = clock_of(start + np.arange(len(record.commands)) * (record.control_every * record.time_step))
    _send_curves(recording, "robot/commands", ticks, record.commands[:, :-1])
    _send_curves(recording, "gripper/force", ticks, record.commands[:, -1:])


def send_seen(
    recording: rr.RecordingStream, seen: Sightings, record: TrialRecord, names: Sequence[str], start: float
) -> None:
    """Where the camera saw each object in a trial that began at ``start`` (s)."""
    at = start + np.array(seen.steps) * record.time_step
    for k, name in enumerate(names):
        there = ~np.isnan(seen.poses[:, k, 0])
        send_poses(recording, f"seen/{entity_of(name)}", clock_of(at[there]), seen.poses[there, k])


def send_arm(recording: rr.RecordingStream, record: TrialRecord, skeleton: Skeleton, start: float) -> None:
    """The arm as a line over its joints, in a trial that began at ``start`` (s)."""
    import rerun as rr

    shown = np.arange(0, record.steps, max(1, round(1 / (_ARM_RATE * record.time_step))))
    lines = skeleton.line(record.joint_positions[shown]).astype(np.float32)
    clock = clock_of(start + (shown + 1) * record.time_step)
    recording.send_columns("world/arm", [clock], rr.LineStrips3D.columns(strips=list(lines)))


def entity_of(name: str) -> str:
    """The path of an object below a root."""
    return f"objects/{_escaped(name)}"


def _escaped(name: str) -> str:
    import rerun as rr

    return rr.escape_entity_path_part(name)  # a name may hold a space or a slash


def clock_of(seconds: NDArray[Any]) -> Any:
    """The simulated ``seconds`` (N,) as a timeline."""
    import rerun as rr

    return rr.TimeColumn("time", duration=seconds)


def send_poses(recording: rr.RecordingStream, entity: str, clock: Any, poses: Array) -> None:
    """Poses (N, 7) of an entity."""
    import rerun as rr

    columns = rr.Transform3D.columns(translation=poses[:, :3], quaternion=poses[:, 3:])
    recording.send_columns(entity, [clock], columns)


def _send_curves(recording: rr.RecordingStream, entity: str, clock: Any, values: Array) -> None:
    import rerun as rr

    columns = rr.Scalars.columns(scalars=values.ravel()).partition([values.shape[1]] * len(values))
    recording.send_columns(entity, [clock], columns)
