"""Orientation as channels: what goes in comes out, and the logarithm is zero at the goal."""

import hypothesis
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from imitate.geometry import align_signs, angle_between
from imitate.policy.dmp import imitate, response, rollout
from imitate.policy.orientation import to_channels, to_poses

vectors = arrays(float, 3, elements=st.floats(-3, 3))


def pose(position, vector):
    return np.concatenate([position, Rotation.from_rotvec(vector).as_quat()])


@given(position=vectors, a=vectors, b=vectors)
@pytest.mark.parametrize("channels", [6, 7])
def test_there_and_back(channels, position, a, b):
    one, goal = pose(position, a), pose(position, b)
    back = to_poses(to_channels(one, goal, channels), goal)
    np.testing.assert_allclose(back[:3], one[:3])
    assert angle_between(back, one) < 1e-7


@given(a=vectors)
def test_the_logarithm_is_zero_at_the_goal_and_as_long_as_the_turn_that_is_left(a):
    goal = pose(np.zeros(3), a)
    assert np.allclose(to_channels(goal, goal, 6)[3:], 0)
    turned = pose(np.zeros(3), [0, 0, 0.4])
    assert np.linalg.norm(to_channels(turned, pose(np.zeros(3), np.zeros(3)), 6)[3:]) == pytest.approx(0.4)


def test_more_than_half_a_circle_keeps_its_way_round():
    turns = np.linspace(0, 4.5, 100)  # 258°
    poses = align_signs(np.array([pose(np.zeros(3), [0, 0, turn]) for turn in turns]))
    log = to_channels(poses, poses[-1], 6)
    np.testing.assert_allclose(log[:, 5], 4.5 - turns, atol=1e-9)


@pytest.mark.parametrize("channels", [6, 7])
def test_a_turn_is_imitated_within_a_tenth_of_a_degree(channels):
    poses = align_signs(np.array([pose([s, 0, 0], [1.2 * s, -0.5 * s, 0.8 * s]) for s in smooth(300)]))
    shape = response(300, 30, 4.6, 50.0)
    shown = to_channels(poses, poses[-1], channels)
    path = to_poses(rollout(shape, shown[0], shown[-1], imitate(shape, shown, shown[-1])), poses[-1])
    assert np.rad2deg(angle_between(path, poses)).max() < 0.1
    np.testing.assert_allclose(np.linalg.norm(path[:, 3:], axis=1), 1)


@pytest.mark.parametrize("original", [False, True])
@pytest.mark.parametrize("channels", [6, 7])
@hypothesis.settings(max_examples=25)
@given(a=arrays(float, 3, elements=st.floats(-0.8, 0.8)), b=arrays(float, 3, elements=st.floats(-0.8, 0.8)))
def test_time_scales_nothing_else_for_poses(channels, original, a, b):
    # One movement's weights over a duration of 300 and of 600 ticks: the same poses at proportional times.
    poses = align_signs(np.array([pose(s * np.ones(3), a + s * (b - a)) for s in smooth(300)]))
    goal = poses[-1]
    shown = to_channels(poses, goal, channels)
    weights = imitate(response(300, 30, 4.6, 50.0, original), shown, shown[-1])
    short, long = (
        to_poses(rollout(response(n, 30, 4.6, 50.0, original), shown[0], shown[-1], weights), goal)
        for n in (300, 599)
    )
    assert np.linalg.norm(long[::2, :3] - short[:, :3], axis=1).max() < 0.01 * np.sqrt(3)
    assert angle_between(long[::2], short).max() <= 0.01 * np.linalg.norm(b - a) + 0.01


def smooth(count):
    """From 0 to 1 with the least jerk."""
    along = np.linspace(0, 1, count)
    return 10 * along**3 - 15 * along**4 + 6 * along**5
