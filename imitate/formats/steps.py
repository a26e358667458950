"""A trial's record ⇄ packed columns: its steps in one message, about 160 bytes a step once zstd has run.

An option is judged after the options before it have run, and from the same starts again and again. Steps
that an earlier trial of the session has too, bit for bit up to where one of its options starts, are not
written twice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import blake2b
from typing import Any

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
        number: counts these messages through the file.
        shared: how many steps at the beginning are not here, but in the message with number ``owner``.
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
    number: int = 0
    shared: int = 0
    owner: int = 0

    @property
    def owns(self) -> bool:
        """Whether a later trial may have steps in common with this one first."""
        return self.option_starts[-1] > self.shared


class Prefixes:
    """Numbers trials, and knows which was the first to have the same steps up to where an option starts."""

    def __init__(self) -> None:
        self._first: dict[bytes, int] = {}
        self._count = 0

    def take(self, record: TrialRecord) -> tuple[int, int, int]:
        """The record's number, how many of its steps an earlier one has too, and that one's number."""
        number, self._count = self._count, self._count + 1
        digest = blake2b(repr((record.time_step, record.control_every, record.start.force)).encode())
        for array in (record.start.joints, record.start.objects):
            digest.update(array.tobytes())
        shared = owner = begun = 0
        for boundary in record.option_starts[1:]:
            if boundary % record.control_every:
                break
            for array in _rows(record, begun, boundary).values():
                digest.update(array.tobytes())
            found = self._first.setdefault(digest.digest(), number)
            if found != number:
                shared, owner = boundary, found
            begun = boundary
        return number, shared, owner


def _rows(record: TrialRecord, begin: int, end: int | None) -> dict[str, Any]:
    """The arrays of a record from one step to another; ``begin`` falls on a command."""
    every = record.control_every
    last = None if end is None else end // every
    rows = {field: getattr(record, field)[begin:end] for field in TrialRecord.STATE_FIELDS}
    return {"commands": record.commands[begin // every : last], **rows}


def pack_record(
    record: TrialRecord, trial: tuple[int, int, int], number: int = 0, shared: int = 0, owner: int = 0
) -> TrialSteps:
    """A record for storage.

    Args:
        record: what the trial recorded.
        trial: its segment, formulation and number there.
        number, shared, owner: as `Prefixes.take` gave them.
    """
    record = replace(record, **_rows(record, shared, None))
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
        number=number,
        shared=shared,
        owner=owner,
    )


def unpack_record(steps: TrialSteps, earlier: TrialRecord | None = None) -> TrialRecord:
    """The record, bit for bit.

    Args:
        steps: as stored.
        earlier: the record number ``steps.owner``, where any steps are shared.

    Raises:
        ValueError: the stored columns do not fit each other.
    """
    joint_velocities, object_velocities = unpack(steps.joint_velocities), unpack(steps.object_velocities)
    positions = unpack(steps.object_positions, object_velocities[..., :3])
    rotations = unpack(steps.object_rotations, object_velocities[..., 3:])
    record = TrialRecord(
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
    if earlier is None or not steps.shared:
        return record
    before, after = _rows(earlier, 0, steps.shared), _rows(record, 0, None)
    whole: dict[str, Any] = {field: np.concatenate([before[field], after[field]]) for field in before}
    return replace(record, **whole)
