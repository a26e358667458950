"""What a physics trial is, as data: the scene, the start, and every step. Knows no simulator."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imitate.geometry import Array, read_only


@dataclass(frozen=True)
class RobotFile:
    """A file that a robot's description leads to.

    Attributes:
        name: its path as seen from the URDF.
        sha256: of its bytes, hexadecimal.
        text: what is in it, of the URDF; empty of a mesh.
    """

    name: str
    sha256: str
    text: str = ""


@dataclass(frozen=True)
class SceneSpec:
    """Everything that physics is built from, in the world frame: z up, z = 0 on the table.

    Attributes:
        robot: name of the robot's description, or its path.
        base: (7,) pose of the arm's base.
        object_names: K names.
        object_sizes: (K, 3) metres.
        object_masses: (K,) kilograms.
        object_poses: (K, 7) as shown at the demonstration's first frame.
        home: (J,) positions of the joints that have a motor, at the start: arm, then fingers; rad, or m where
            a joint slides.
        description: the robot's description itself, TOML; sessions of before it was kept have none.
        robot_files: what the description leads to; none where it ships with imitate.
    """

    robot: str
    base: Array
    object_names: tuple[str, ...]
    object_sizes: Array
    object_masses: Array
    object_poses: Array
    home: Array
    description: str = ""
    robot_files: tuple[RobotFile, ...] = ()

    def __post_init__(self) -> None:
        for field in ("base", "object_sizes", "object_masses", "object_poses", "home"):
            object.__setattr__(self, field, read_only(getattr(self, field)))


@dataclass(frozen=True)
class Start:
    """Where a trial starts, everything at rest.

    Attributes:
        joints: (J,) arm, then fingers.
        objects: (K, 7) world poses.
        force: the gripper's command at the start, N; > 0 closed with that force, else open.
    """

    joints: Array
    objects: Array
    force: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", read_only(self.joints))
        object.__setattr__(self, "objects", read_only(self.objects))


@dataclass(frozen=True)
class TrialRecord:
    """Every step of one trial: N physics steps, one command for every ``control_every`` of them.

    Attributes:
        start: where it started.
        time_step: seconds of one physics step.
        control_every: physics steps to a command.
        option_starts: for each option run in a row, the step at which it starts (the first is 0).
        commands: (⌈N / control_every⌉, A + 1) arm joint targets (rad), then the gripper's force λ (N): λ > 0
            closes with that force, else the gripper opens.
        joint_positions: (N, J) after each step; rad, or m where a joint slides.
        joint_velocities: (N, J) rad/s and m/s.
        hand_poses: (N, 7) world poses of the tool-centre point.
        object_poses: (N, K, 7) world poses.
        object_velocities: (N, K, 6) linear m/s, then angular rad/s.
        contact_forces: (N, K) sum of the normal forces between the robot and each object, N.
    """

    start: Start
    time_step: float
    control_every: int
    option_starts: tuple[int, ...]
    commands: Array
    joint_positions: Array
    joint_velocities: Array
    hand_poses: Array
    object_poses: Array
    object_velocities: Array
    contact_forces: Array

    STATE_FIELDS = (
        "joint_positions",
        "joint_velocities",
        "hand_poses",
        "object_poses",
        "object_velocities",
        "contact_forces",
    )

    def __post_init__(self) -> None:
        for field in ("commands", *self.STATE_FIELDS):
            object.__setattr__(self, field, read_only(getattr(self, field)))

    @property
    def steps(self) -> int:
        """How many physics steps were taken."""
        return int(self.joint_positions.shape[0])


@dataclass(frozen=True)
class Sightings:
    """Where objects were seen in a trial: F looks at K objects. What is believed between and before them.

    Attributes:
        expected: (K, 7) world poses that were thought of before the first look.
        steps: F ascending numbers of physics steps that had been taken when the look was.
        poses: (F, K, 7) world poses; seven NaN where an object was not seen.
    """

    expected: Array
    steps: tuple[int, ...]
    poses: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "expected", read_only(self.expected))
        object.__setattr__(self, "poses", read_only(self.poses))

    @property
    def believed(self) -> Array:
        """(1 + F, K, 7) before the first look and after each: where each object was seen last."""
        all_poses = np.concatenate([self.expected[None], self.poses])
        rows = np.arange(len(all_poses))[:, None] * ~np.isnan(all_poses[..., 0])
        last = np.maximum.accumulate(rows, axis=0)
        return np.asarray(all_poses[last, np.arange(all_poses.shape[1])])

    @property
    def in_sight(self) -> tuple[bool, ...]:
        """Whether each object was seen in the last look."""
        return tuple(bool(seen) for seen in ~np.isnan(self.poses[-1, :, 0]))


def as_seen(record: TrialRecord, seen: Sightings | None) -> TrialRecord:
    """The record with each object where it was seen last instead of where physics had it.

    Its velocities and contacts stay those of physics; without sightings it is the record itself.
    """
    if seen is None:
        return record
    where = seen.believed[np.searchsorted(seen.steps, np.arange(record.steps + 1), side="right")]
    return replace(record, start=replace(record.start, objects=where[0]), object_poses=where[1:])
