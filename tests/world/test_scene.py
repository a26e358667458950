"""A scene from a demonstration: sizes, reach and robots, with messages that say what is wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imitate.errors import FileError, SceneError, UnknownNameError
from imitate.geometry import angle_between
from imitate.settings import Settings
from imitate.settings import World as WorldSettings
from imitate.world.kinematics import Arm
from imitate.world.robot import _SHIPPED, load_robot
from imitate.world.scene import check_within_reach, scene_of

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
