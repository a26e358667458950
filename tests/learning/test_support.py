"""What stands on what, and what hangs in the air."""

from dataclasses import replace

import numpy as np
import pytest
from test_places import STAYED, shown

from imitate.demonstration import Demonstration
from imitate.geometry import from_yaw
from imitate.learning.support import hang_in_air, standing_on

CUBES = np.full((2, 3), 0.04)


def test_a_box_stands_on_the_one_that_it_touches():
    sizes = np.full((3, 3), 0.04)
    poses = np.tile([0.0, 0, 0.02, 0, 0, 0, 1], (3, 1))
    poses[1, 2] = 0.06
    poses[2, 0] = 0.2
    assert standing_on(poses, sizes).tolist() == [-1, 0, -1]
    poses[1, 2] = 0.068
    assert standing_on(poses, sizes).tolist() == [-1, -1, -1]


@pytest.mark.parametrize(("lift", "hangs"), [(0.03, ("a",)), (0.008, ()), (0.0, ())])
def test_what_is_lifted_hangs(lift, hangs):
    demonstration = shown(((0, 0, lift), 0), STAYED)
    assert hang_in_air(demonstration, ("a", "b"), 2.0) == hangs
    assert hang_in_air(demonstration, ("b",), 2.0) == ()
    assert hang_in_air(demonstration, ("a", "b"), 0.2) == ()


def test_what_is_put_on_another_does_not_hang():
    stacked = shown(((0.3, 0, 0.04), 0), STAYED)
    assert hang_in_air(stacked, ("a",), 2.0) == ()
    assert hang_in_air(stacked, ("a",), 1.0) == ("a",)


def test_of_what_has_no_size_nobody_knows():
    lifted = shown(((0, 0, 0.1), 0), STAYED)
    assert hang_in_air(replace(lifted, object_sizes=np.full((2, 3), np.nan)), ("a",), 2.0) == ()


def pair(across, gap, yaw=0.0):
    """The first cube over the second, beside it by ``across`` m with ``gap`` m between."""
    return np.array([from_yaw([0.5 + across, 0, 0.06 + gap], yaw), from_yaw([0.5, 0, 0.02], 0.0)])


@pytest.mark.parametrize(
    ("across", "gap", "stands"),
    [
        (0.0, 0.0, True),
        (0.028, 0.004, True),  # over its corner still
        (0.029, 0.0, False),
        (0.0, 0.006, False),
        (0.0, -0.004, True),
        (0.0, -0.006, False),
    ],
)
def test_what_is_beside_another_or_over_a_gap_does_not_stand_on_it(across, gap, stands):
    assert standing_on(pair(across, gap), CUBES).tolist() == [1 if stands else -1, -1]


def test_how_much_may_lie_between_can_be_said():
    assert standing_on(pair(0.0, 0.008), CUBES, 0.01).tolist() == [1, -1]


def test_a_box_on_its_side_is_as_high_as_it_then_is():
    # 10 cm long, standing on end: its centre is 5 cm up, and what lies on it is 12 cm up.
    sizes = np.array([[0.04, 0.04, 0.04], [0.1, 0.02, 0.02]])
    upright = np.array([0.5, 0, 0.05, 0, np.sqrt(0.5), 0, np.sqrt(0.5)])
    poses = np.array([from_yaw([0.5, 0, 0.12], 0.0), upright])
    assert standing_on(poses, sizes).tolist() == [1, -1]
    assert standing_on(poses + [0, 0, 0.02, 0, 0, 0, 0] * np.array([[1], [0]]), sizes).tolist() == [-1, -1]


def lifted(heights, across=0.3):
    """A second in which the first cube goes evenly from one height of its centre to another, m."""
    t = np.linspace(5, 6, 11)
    poses = np.tile(from_yaw([0.5, 0, 0.02], 0.0), (11, 2, 1))
    poses[:, 0, 2], poses[:, 0, 0] = np.linspace(*heights, 11), 0.5 + across
    return Demonstration(t, poses[:, 1], poses, ("red", "blue"), CUBES)


@pytest.mark.parametrize(
    ("heights", "across", "time", "hangs"),
    [
        ((0.02, 0.12), 0.3, 1.0, ("red",)),
        ((0.02, 0.12), 0.3, 0.0, ()),
        ((0.02, 0.029), 0.3, 1.0, ()),
        ((0.02, 0.031), 0.3, 1.0, ("red",)),
        ((0.02, 0.068), 0.0, 1.0, ()),  # on the other one, nearly
        ((0.02, 0.072), 0.0, 1.0, ("red",)),
    ],
)
def test_what_is_held_over_anything_by_more_than_a_centimetre_hangs(heights, across, time, hangs):
    held = lifted(heights, across)
    assert hang_in_air(held, ("red", "blue"), time) == hangs
    assert hang_in_air(held, ("blue",), time) == ()
