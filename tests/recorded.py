"""Trials as physics would record them, without physics: positions that follow from random velocities."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scripted
from scipy.spatial.transform import Rotation

from imitate import events
from imitate.geometry import normalised
from imitate.record import Start, TrialRecord

STEP = 1 / 240


def record(steps: int = 40, seed: int = 0, objects: int = 2, joints: int = 9) -> TrialRecord:
    """A trial of ``steps`` steps; every fourth step has a command."""
    rng = np.random.default_rng(seed)
    start = Start(rng.normal(size=joints), normalised(rng.normal(size=(objects, 7))), 2.5)
    joint_velocities = np.cumsum(rng.normal(0, 0.02, (steps, joints)), axis=0)
    joint_positions = np.add.accumulate(np.vstack([start.joints, joint_velocities * STEP]))[1:]
    object_velocities = np.cumsum(rng.normal(0, 0.02, (steps, objects, 6)), axis=0)
    poses = [start.objects]
    for velocity in object_velocities:
        moved = np.array(poses[-1])
        moved[:, :3] += velocity[:, :3] * STEP
        for body, rate in zip(moved, velocity[:, 3:], strict=True):
            body[3:] = (Rotation.from_rotvec(rate * STEP) * Rotation.from_quat(body[3:])).as_quat()
        poses.append(moved)
    return TrialRecord(
        start=start,
        time_step=STEP,
        control_every=4,
        option_starts=(0, steps // 2),
        commands=rng.normal(size=(-(-steps // 4), joints - 1)),
        joint_positions=joint_positions,
        joint_velocities=joint_velocities,
        hand_poses=normalised(rng.normal(size=(steps, 7))),
        object_poses=np.array(poses[1:]).reshape(steps, objects, 7),
        object_velocities=object_velocities,
        contact_forces=np.maximum(0, rng.normal(size=(steps, objects))),
    )


def session(steps: int = 40) -> Iterator[events.Event]:
    """The scripted session, each of its trials with a record of its own."""
    count = 0
    for event in scripted.session():
        if isinstance(event, events.TrialFinished):
            event = replace(event, record=record(steps + count % 3, seed=count))
            count += 1
        yield event


def same(a: object, b: object) -> bool:
    """Whether two events, or parts of them, are equal, arrays bit for bit."""
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if type(a) is type(b) and hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, name), getattr(b, name)) for name in a.__dataclass_fields__)
    return type(a) is type(b) and a == b
