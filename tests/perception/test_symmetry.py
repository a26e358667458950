"""Boxes that look the same, and boxes that lie flat."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from imitate.geometry import angle_between, quaternion_multiply, rotate
from imitate.perception.symmetry import flat, half_height, nearest_alike, tilt, turns

angles = st.floats(-3, 3)
vectors = st.tuples(angles, angles, angles).map(np.array)


def pose(turn):
    return np.concatenate([[0.1, 0.2, 0.3], Rotation.from_rotvec(turn).as_quat()])


@pytest.mark.parametrize(
    ("size", "count"), [([0.04, 0.06, 0.09], 4), ([0.04, 0.04, 0.09], 8), ([0.05, 0.05, 0.05], 24)]
)
def test_a_box_looks_the_same_after_the_turns_of_its_group(size, count):
    assert len(turns(np.array(size))) == count


@given(vectors, st.integers(0, 7))
def test_a_track_does_not_hop_to_another_of_its_symmetric_poses(turn, k):
    size = np.array([0.05, 0.05, 0.08])
    last = pose(turn)
    group = turns(size)
    moved = pose(turn)
    moved[3:] = quaternion_multiply(
        quaternion_multiply(Rotation.from_rotvec([0.1, 0.05, 0]).as_quat(), last[3:]), group[k]
    )
    found = nearest_alike(moved, size, last)
    assert angle_between(found, last) < 0.12
    np.testing.assert_array_equal(found[:3], moved[:3])


@given(vectors)
def test_a_flat_box_has_an_axis_upright_and_is_turned_by_its_tilt(turn):
    leaning = pose(turn)
    angle, _ = tilt(leaning)
    upright = flat(leaning)
    assert np.abs(rotate(upright[3:], np.eye(3))[:, 2]).max() == pytest.approx(1, abs=1e-9)
    assert angle_between(leaning, upright) == pytest.approx(angle, abs=1e-6)
    assert angle <= np.arccos(1 / np.sqrt(3)) + 1e-9


def test_the_lowest_point_of_a_box_on_its_edge():
    size = np.array([0.04, 0.06, 0.08])
    assert half_height(pose([0, 0, 1.0]), size) == pytest.approx(0.04)
    assert half_height(pose([np.pi / 4, 0, 0]), size) == pytest.approx((0.06 + 0.08) / 2 / np.sqrt(2))
