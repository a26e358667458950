"""Arms as data: each has the tool-centre point's frame, closes on a cube and lifts it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imitate.demonstration import Demonstration
from imitate.errors import FileError, SceneError, UnknownNameError
from imitate.geometry import compose, from_yaw
from imitate.record import Start, TrialRecord
from imitate.settings import Settings
from imitate.settings import World as WorldSettings
from imitate.world.gripper import gaps, opening
from imitate.world.kinematics import Arm
from imitate.world.robot import _SHIPPED, load_robot, parse_robot
from imitate.world.scene import World, scene_of
from imitate.world.trial import Simulator

BAXTER = Path(__file__).parent / "baxter.toml"
HAS_BAXTER = Path(load_robot(str(BAXTER)).urdf).is_absolute()
ROBOTS = [
    *sorted(path.stem for path in _SHIPPED.glob("*.toml")),
    pytest.param(
        str(BAXTER), id="baxter", marks=pytest.mark.skipif(not HAS_BAXTER, reason="no ../shared/data/baxter")
    ),
]
PANDA = (_SHIPPED / "panda.toml").read_text()


def lowered_and_lifted(size: float) -> Demonstration:
    """A hand that comes down on a cube from 20 cm within 1.5 s, waits a second and goes up again."""
    t = np.linspace(0, 4, 81)
    height = np.interp(t, [0, 1.5, 2.5, 4], [0.2, size / 2, size / 2, 0.2])
    down = compose([0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 1, 0, 0, 0])[3:]
    hand = np.array([[0, 0, z, *down] for z in height])
    cube = np.tile([0, 0, size / 2, 0, 0, 0, 1.0], (len(t), 1, 1))
    return Demonstration(
        t=t, hand=hand, objects=cube, object_names=("cube",), object_sizes=np.full((1, 3), size)
    )


def picked(robot: str, size: float, force: float = 20.0) -> TrialRecord:
    """What becomes of a cube when the hand closes on it at 1.6 s."""
    settings = Settings(world=WorldSettings(robot=robot, reach_rate=3))
    shown = lowered_and_lifted(size)
    spec = scene_of(shown, settings.world)
    simulator = Simulator(World(spec, settings.world), settings)
    arm = len(simulator.arm.joints)
    at = np.arange(0, 4, 1 / 60)
    heights = np.interp(at, shown.t, shown.hand[:, 2])
    path = np.array([[0, 0, z, *shown.hand[0, 3:]] for z in heights])
    joints = simulator.arm.solve(spec.base, path, spec.home[:arm]).joints
    steps = 4 * len(at)
    planned = TrialRecord(
        start=Start(spec.home, spec.object_poses),
        time_step=1 / 240,
        control_every=4,
        option_starts=(0,),
        commands=np.column_stack([joints, np.where(at > 1.6, force, 0.0)]),
        joint_positions=np.zeros((steps, len(spec.home))),
        joint_velocities=np.zeros((steps, len(spec.home))),
        hand_poses=np.zeros((steps, 7)),
        object_poses=np.zeros((steps, 1, 7)),
        object_velocities=np.zeros((steps, 1, 6)),
        contact_forces=np.zeros((steps, 1)),
    )
    try:
        return simulator.resimulate(planned)
    finally:
        simulator.close()


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_tool_centre_point_lies_between_the_fingertips_which_open_along_its_y(robot):
    described = load_robot(robot)
    left, right = gaps(described)
    assert abs(left - right) < 1e-3
    assert 0.03 < left + right < 0.2
    travel = 2 * described.finger_lever * abs(described.finger_closed[0] - described.finger_open[0])
    assert opening(described) - opening(described, closed=1.0) == pytest.approx(travel, rel=0.1)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("size", [0.04, 0.05])
def test_it_closes_on_a_cube_and_lifts_it(robot, size):
    record = picked(robot, size)
    hand, cube = record.hand_poses[-1], record.object_poses[-1, 0]
    assert hand[2] > 0.19
    assert np.linalg.norm(cube[:3] - hand[:3]) < 0.003
    assert record.contact_forces[: 240 * 3 // 2].max() == 0  # the open hand fits around it
    assert 30 < np.median(record.contact_forces[-240:]) < 55  # 20 N from either side
    fingers = load_robot(robot)
    ends = np.array([fingers.finger_open, fingers.finger_closed])
    closed = (record.joint_positions[-1, -len(ends[0]) :] - ends[0]) / (ends[1] - ends[0])
    assert np.ptp(closed) < 0.05


def test_what_a_robot_does_not_use_is_held_where_its_description_says(tmp_path):
    text = PANDA.replace('"panda_joint1", ', "").replace("rest = [0.0, ", "rest = [")
    path = tmp_path / "short.toml"
    path.write_text(text + "[held]\npanda_joint1 = 0.4\n")
    spec = scene_of(lowered_and_lifted(0.04), WorldSettings())
    turned = replace(spec, robot=str(path), description=path.read_text(), home=np.delete(spec.home, 0))
    world = World(turned, WorldSettings())
    world.reset(Start(turned.home, turned.object_poses))
    joint = world.client.names(world.body.number)[0]["panda_joint1"]
    for _ in range(240):
        world.client.stepSimulation()
    held = world.client.getJointState(world.body.number, joint)[0]
    world.close()
    assert held == pytest.approx(0.4, abs=1e-3)


def test_the_inverse_kinematics_reaches_links_whose_inertia_is_turned():
    # PyBullet's solver answers in the frame of a link's inertia.
    if not HAS_BAXTER:
        pytest.skip("no ../shared/data/baxter")
    arm = Arm(load_robot(str(BAXTER)))
    base, rest = from_yaw([0.1, 0.2, 0.3], 0.4), np.array(arm.robot.rest)
    pose = arm.forward(base, rest)
    found = arm.solve(base, pose[None], rest + 0.05, first_rounds=20)
    arm.close()
    assert found.distance[0] < 1e-3
    assert found.angle[0] < 0.01


def test_no_joint_goes_beyond_its_limit():
    arm = Arm(load_robot("panda"))
    far = np.array([[1.5, 0, 0.2, 1, 0, 0, 0.0], [0.05, 0, 0.05, 1, 0, 0, 0.0]])
    found = arm.solve(np.array([0, 0, 0, 0, 0, 0, 1.0]), far, np.array(arm.robot.rest), first_rounds=30)
    arm.close()
    assert np.all(found.joints >= arm.lower)
    assert np.all(found.joints <= arm.upper)
    assert found.distance[0] > 0.5


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("finger_open = 0.04", "finger_wide = 0.04", "lacks finger_open. A robot has arm"),
        ("reach = 0.855", "reach = 0.855\ngripper = 1", "unknown gripper. .*may have base_bearing"),
        ("finger_open = 0.04", "finger_open = [0.04]", "finger_open has 1 numbers. Expected one for each"),
        ("finger_open = 0.04", "finger_open = 0.0", "finger_open and finger_closed of panda_finger_joint1"),
        ("reach = 0.855", "reach = -1", "reach = -1. Expected a number above 0"),
        ("tcp = [0.0, ", "tcp = [", "tcp has 6 numbers. Expected 7 numbers, x y z qx qy qz qw"),
        ("reach = 0.855", "reach = 0.855\nsolver_iterations = 0.5", "Expected a whole number"),
        ("reach = 0.855", "reach = 0.855\n[followers]\npanda_joint8 = [0.0]", "followers.panda_joint8 has 1"),
        ("reach = 0.855", "reach = 0.855\n[held]\npanda_joint1 = 0.0", "names panda_joint1 twice"),
        ("reach = 0.855", "reach = 0.855\n[held]\npanda_joint1 = 'up'", "a table of joint = position"),
        ("reach = 0.855", "reach =", "is not TOML"),
    ],
)
def test_a_wrong_description_says_what_is_wrong(old, new, expected):
    assert old in PANDA
    with pytest.raises(FileError, match=expected):
        parse_robot(PANDA.replace(old, new), "arm.toml")


def test_a_joint_that_is_not_there_lists_those_that_move():
    described = parse_robot(PANDA.replace("panda_joint7", "panda_joint8"), "arm.toml")
    with pytest.raises(
        SceneError, match=r"no joint panda_joint8; its movable joints are panda_joint1, .*joint7"
    ):
        gaps(described)


def test_an_unknown_name_lists_the_robots():
    with pytest.raises(UnknownNameError, match="Valid: iiwa, panda, xarm6"):
        load_robot("kuka")
