"""A trial whose numbers are kept in golden.npz: its scene, start and policies as data, of no learning.

`python tests/world/golden.py` records it anew, where physics or a policy's equations change on purpose.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from imitate.demonstration import TABLE
from imitate.record import SceneSpec, Start, TrialRecord
from imitate.session.versions import versions
from imitate.settings import parse_settings
from imitate.skill import Policy
from imitate.world.scene import World
from imitate.world.trial import Simulator

FILE = Path(__file__).with_suffix(".npz")
FIELDS = ("commands", *TrialRecord.STATE_FIELDS)

SETTINGS = parse_settings(
    {
        "world": {
            "physics_rate": 240,
            "control_rate": 60,
            "settle_time": 0.1,
            "position_gain": 0.3,
            "solver_iterations": 50,
            "object_friction": 0.6,
            "table_friction": 0.8,
            "spinning_friction": 0.001,
        },
        "policy": {
            "form": "hoffmann",
            "phase_decay": 4.6,
            "stiffness": 50.0,
            "gripper_decay": 0.0,
            "gripper_stiffness": 50.0,
            "open_below": 2.0,
        },
    }
)
JOINTS = [0.0, 0.454977, 0.0, -2.366842, 0.0, 2.821819, 0.78539, 0.04, 0.04]
"""The arm with its fingers round the block."""
SCENE = SceneSpec(
    robot="panda",
    base=np.array([-0.5, 0, 0, 0, 0, 0, 1]),
    object_names=("block",),
    object_sizes=np.array([[0.04, 0.04, 0.04]]),
    object_masses=np.array([0.064]),
    object_poses=np.array([[0, 0, 0.02, 0, 0, 0, 1]]),
    home=np.array(JOINTS),
)
START = Start(np.array(JOINTS), SCENE.object_poses)
GRASP = Policy(
    reference="block",
    duration=0.4,
    start=np.array([0, 0, 0.01, 1, 0, 0, 0]),
    goal=np.array([0, 0, 0.01, 1, 0, 0, 0]),
    pose_weights=np.zeros((10, 6)),
    gripper_weights=np.array([40.0, 40.0, 40.0, 60.0, 200.0]),
    wait=0.05,
)
CARRY = Policy(
    reference=TABLE,
    duration=0.8,
    start=np.array([0, 0, 0.03, 1, 0, 0, 0]),
    goal=np.array([0.03, -0.02, 0.11, 0.9987502603949663, 0.04997916927067833, 0, 0]),
    pose_weights=(np.arange(60) * 37 % 21 - 10).reshape(10, 6) / 2000,
    gripper_weights=np.zeros(0),
)
POLICIES = (GRASP, CARRY)
"""The second keeps the gripper's force."""


def simulator() -> Simulator:
    """Of the scene."""
    return Simulator(World(SCENE, SETTINGS.world), SETTINGS)


def recorded() -> tuple[TrialRecord, Mapping[str, str]]:
    """The trial as it was recorded, and with what."""
    with np.load(FILE) as file:
        arrays: dict[str, Any] = {field: file[field] for field in FIELDS}
        option_starts = tuple(file["option_starts"].tolist())
        made_with = json.loads(str(file["versions"]))
    return TrialRecord(START, 1 / 240, 4, option_starts, **arrays), made_with


def main() -> None:
    """Records it."""
    made = simulator()
    record = made.run(START, POLICIES).record
    made.close()
    arrays = {field: getattr(record, field) for field in FIELDS}
    starts = np.array(record.option_starts)
    np.savez_compressed(FILE, option_starts=starts, versions=json.dumps(versions()), **arrays)


if __name__ == "__main__":
    main()
