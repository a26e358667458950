"""Axioms of poses: group laws, rigidity, and what resampling keeps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from imitate.geometry import (
    IDENTITY,
    align_signs,
    angle_between,
    compose,
    from_yaw,
    inverse,
    normalised,
    quaternion_multiply,
    read_only,
    relative,
    resample,
    rotate,
)

SEEDS = st.integers(0, 2**32 - 1)


def random_poses(seed: int, *shape: int) -> np.ndarray:
    return normalised(np.random.default_rng(seed).normal(size=(*shape, 7)))


def assert_same(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(a[..., :3], b[..., :3], atol=1e-9)
    np.testing.assert_allclose(angle_between(a, b), 0, atol=1e-7)


@given(SEEDS)
def test_poses_are_a_group(seed):
    a, b, c = random_poses(seed, 3)
    assert_same(compose(compose(a, b), c), compose(a, compose(b, c)))
    assert_same(compose(a, inverse(a)), IDENTITY)
    assert_same(compose(inverse(a), a), IDENTITY)
    assert_same(compose(a, IDENTITY), a)
    assert_same(inverse(compose(a, b)), compose(inverse(b), inverse(a)))


@given(SEEDS)
def test_relative_is_what_composes_back_and_forgets_the_frame(seed):
    world, a, b = random_poses(seed, 3)
    assert_same(compose(a, relative(a, b)), b)
    assert_same(relative(compose(world, a), compose(world, b)), relative(a, b))


@given(SEEDS)
def test_rotations_agree_with_scipy(seed):
    a, b = random_poses(seed, 2)
    point = np.random.default_rng(seed).normal(size=3)
    np.testing.assert_allclose(rotate(a[3:], point), Rotation.from_quat(a[3:]).apply(point), atol=1e-9)
    both = Rotation.from_quat(a[3:]) * Rotation.from_quat(b[3:])
    assert_same(np.r_[0, 0, 0, quaternion_multiply(a[3:], b[3:])], np.r_[0, 0, 0, both.as_quat()])
    expected = (Rotation.from_quat(a[3:]).inv() * Rotation.from_quat(b[3:])).magnitude()
    assert angle_between(a, b) == pytest.approx(expected, abs=1e-7)


@given(SEEDS)
def test_aligned_signs_are_the_same_rotations_without_jumps(seed):
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(np.cumsum(rng.normal(scale=0.1, size=(50, 3)), axis=0)).as_quat()
    poses = np.column_stack([rng.normal(size=(50, 3)), turn * rng.choice([-1, 1], (50, 1))])
    aligned = align_signs(poses)
    assert_same(aligned, poses)
    np.testing.assert_array_equal(aligned[0], poses[0])
    assert np.all(np.sum(aligned[1:, 3:] * aligned[:-1, 3:], axis=1) > 0)
    to = -poses[0]
    assert align_signs(poses, to)[0, 3:] @ to[3:] > 0


@given(SEEDS)
def test_resampling_keeps_the_given_frames_and_is_clamped(seed):
    rng = np.random.default_rng(seed)
    t, poses = np.cumsum(rng.uniform(0.01, 0.1, 12)), random_poses(seed, 12, 2)
    assert_same(resample(t, poses, t), poses)
    assert_same(resample(t, poses, [t[0] - 1, t[-1] + 1]), poses[[0, -1]])
    between = resample(t, poses, rng.uniform(t[0], t[-1], 20))
    np.testing.assert_allclose(np.linalg.norm(between[..., 3:], axis=-1), 1)


def test_halfway_is_half_the_turn_whatever_the_sign():
    a, b = from_yaw(np.zeros(3), np.array(0.2)), from_yaw(np.ones(3), np.array(1.0))
    for sign in (1, -1):
        end = b * [1, 1, 1, sign, sign, sign, sign]
        (half,) = resample([0.0, 2.0], np.stack([a, end]), [1.0])
        assert_same(half, from_yaw(np.full(3, 0.5), np.array(0.6)))


def test_read_only_copies_what_could_change():
    values = np.zeros(3)
    kept = read_only(values)
    values[0] = 1
    assert kept[0] == 0
    assert not kept.flags.writeable
    assert read_only(kept) is kept
