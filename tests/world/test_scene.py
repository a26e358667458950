"""A scene from a demonstration: sizes, reach and robots, with messages that say what is wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imitate.errors import FileError, SceneError, UnknownNameError
from imitate.geometry import angle_between
from imitate.settings import Settings
from imitate.settings import World as WorldSettings
from imitate.skill import Abstraction, Segment
from imitate.world.kinematics import Arm
from imitate.world.robot import _SHIPPED, load_robot
from imitate.world.scene import check_grasps, check_within_reach, scene_of
from imitate.world.touching import touching

PANDA = Path(_SHIPPED) / "panda.toml"


def test_the_arm_stands_where_it_reaches_the_first_hand_pose(short_demonstration):
    spec = scene_of(short_demonstration, WorldSettings())
    arm = Arm(load_robot("panda"))
    reached = arm.forward(spec.base, spec.home[:7])
    arm.close()
    assert np.linalg.norm(reached[:3] - short_demonstration.hand[0, :3]) < 0.005
    assert angle_between(reached, short_demonstration.hand[0]) < 0.05


def test_an_object_without_a_size_is_named(short_demonstration):
    sizes = short_demonstration.object_sizes.copy()
    sizes[1, 0] = np.nan
    with pytest.raises(SceneError, match=r"size of cubeB is not known.*object_sizes"):
        scene_of(replace(short_demonstration, object_sizes=sizes), WorldSettings())


def test_a_hand_out_of_reach_is_named_with_its_time_and_place(short_demonstration):
    d = short_demonstration
    far = d.hand.copy()
    far[:, 0] += np.linspace(0, 4, len(far))
    with pytest.raises(SceneError, match=r"out of reach: the hand's pose at [\d.]+ s.*missed by \d+ mm"):
        scene_of(replace(d, hand=far), WorldSettings())


def test_an_object_far_from_the_hand_is_out_of_reach(short_demonstration):
    d = short_demonstration
    objects = d.objects.copy()
    objects[:, 1, 0] += 3
    spec = scene_of(replace(d, objects=objects), WorldSettings())
    check_within_reach(spec, ["cubeA"])
    with pytest.raises(SceneError, match=r"cubeB is out of reach.*panda reaches 0.855 m"):
        check_within_reach(spec, ["cubeA", "cubeB"])


def test_an_unknown_robot_lists_those_there_are():
    with pytest.raises(UnknownNameError, match=r"unknown robot 'pandda'. Did you mean 'panda'"):
        load_robot("pandda")


def test_a_robots_file_without_a_field_says_which(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(PANDA.read_text().replace("finger_open", "finger_wide"))
    with pytest.raises(FileError, match=r"arm.toml: lacks finger_open"):
        load_robot(str(path))


def test_a_missing_robots_file_is_said():
    with pytest.raises(FileError, match=r"nowhere.toml: no such robot description"):
        load_robot("nowhere.toml")


def test_rates_must_divide():
    with pytest.raises(ValueError, match="whole multiple"):
        Settings(world=WorldSettings(physics_rate=240, control_rate=70))


def carried_from(demonstration, time):
    return [Segment(time, demonstration.t[-1], Abstraction(("hand", "cubeA"), "cubeB"), ())]


@pytest.mark.parametrize(("width", "robot", "fits"), [(0.07, "panda", True), (0.09, "panda", False)])
def test_what_is_too_wide_for_the_fingers_is_refused(short_demonstration, width, robot, fits):
    d = short_demonstration
    sizes = d.object_sizes.copy()
    sizes[0] = [width, width, 0.04]
    spec = scene_of(replace(d, object_sizes=sizes), WorldSettings(robot=robot, reach_rate=2))
    if fits:
        check_grasps(spec, d, carried_from(d, 1.0))
        return
    with pytest.raises(SceneError, match=r"cubeA is 90 mm wide .* gripper of panda opens 78 mm"):
        check_grasps(spec, d, carried_from(d, 1.0))


def test_what_is_pushed_from_outside_may_be_wider_than_the_gripper_opens(short_demonstration):
    d = short_demonstration
    sizes = d.object_sizes.copy()
    sizes[0] = [0.2, 0.2, 0.04]
    hand = d.hand.copy()
    hand[:, :2] += 0.15
    spec = scene_of(replace(d, object_sizes=sizes), WorldSettings(reach_rate=2))
    check_grasps(spec, replace(d, hand=hand), carried_from(d, 1.0))


def test_an_arm_that_bends_into_itself_or_the_table_touches():
    arm = Arm(load_robot("iiwa"))
    rest, folded = np.array(arm.robot.rest), np.array([0, 0.5, 0, -2.09, 0, 2.09, 0])
    names = {number: name for name, number in arm.client.names(arm.body)[1].items()}
    apart, folds = touching(arm, rest, 0.0), touching(arm, folded, 0.0)
    low = touching(arm, np.array([0, 1.9, 0, 0, 0, 0, 0]), 0.0)
    arm.close()
    assert not apart
    assert any("finger" in names[high] and "link" in names[low] for low, high in folds)
    assert any(first == -2 for first, _ in low)
