"""A trial's record ⇄ packed columns: every step in one message, about 150 bytes a step once zstd has run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imitate.formats.columns import Packed, pack, pack_integral, pack_rotations, unpack
from imitate.record import Start, TrialRecord


@dataclass(frozen=True)
class TrialSteps:
    """A `TrialRecord` as it is stored. Positions follow from velocities; see `imitate.formats.columns`.

    Attributes:
        segment, formulation, trial: of the trial, as in its TrialFinished.
        start, time_step, control_every, option_starts: as in the record.
        commands, joint_velocities, hand_poses, object_velocities, contact_forces: its arrays.
        joint_positions: expected from joint_velocities.
        object_positions: (N, K, 3), expected from object_velocities[..., :3].
        object_rotations: (N, K, 4), expected from object_velocities[..., 3:].
    """

    segment: int
    formulation: int
    trial: int
    start: Start
    time_step: float
    control_every: int
    option_starts: tuple[int, ...]
    commands: Packed
    joint_positions: Packed
    joint_velocities: Packed
    hand_poses: Packed
    object_positions: Packed
    object_rotations: Packed
    object_velocities: Packed
    contact_forces: Packed


def pack_record(record: TrialRecord, trial: tuple[int, int, int]) -> TrialSteps:
    """A record for storage.

    Args:
        record: what the trial recorded.
        trial: its segment, formulation and number.
    """
    poses, velocities, dt = record.object_poses, record.object_velocities, record.time_step
    # the orders of difference that came out smallest on a human stacking demonstration done by the Panda
    return TrialSteps(
        *trial,
        start=record.start,
        time_step=dt,
        control_every=record.control_every,
        option_starts=record.option_starts,
        commands=pack(record.commands, 2),
        joint_positions=pack_integral(record.joint_positions, record.joint_velocities, dt, 2),
        joint_velocities=pack(record.joint_velocities, 1),
        hand_poses=pack(record.hand_poses, 3),
        object_positions=pack_integral(poses[..., :3], velocities[..., :3], dt, 3),
        object_rotations=pack_rotations(poses[..., 3:], velocities[..., 3:], dt, 3),
        object_velocities=pack(velocities, 2),
        contact_forces=pack(record.contact_forces, 1),
    )


def unpack_record(steps: TrialSteps) -> TrialRecord:
    """The record, bit for bit.

    Raises:
        ValueError: the stored columns do not fit each other.
    """
    joint_velocities, object_velocities = unpack(steps.joint_velocities), unpack(steps.object_velocities)
    positions = unpack(steps.object_positions, object_velocities[..., :3])
    rotations = unpack(steps.object_rotations, object_velocities[..., 3:])
    return TrialRecord(
        start=steps.start,
        time_step=steps.time_step,
        control_every=steps.control_every,
        option_starts=steps.option_starts,
        commands=unpack(steps.commands),
        joint_positions=unpack(steps.joint_positions, joint_velocities),
        joint_velocities=joint_velocities,
        hand_poses=unpack(steps.hand_poses),
        object_poses=np.concatenate([positions, rotations], axis=-1),
        object_velocities=object_velocities,
        contact_forces=unpack(steps.contact_forces),
    )
