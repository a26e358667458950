"""Noise is measured in motion; what was not seen or is frozen is not believed."""

import numpy as np
import pytest

from imitate.geometry import from_yaw
from imitate.segmentation.tracks import believable, noise, track_of, turn_noise
from imitate.settings import load_settings

ROBUST = load_settings().segmentation
STEADY = from_yaw(np.arange(40)[:, None] * np.array([0.01, 0, 0]), np.full(40, 0.3))


@pytest.mark.parametrize("sigma", [0.0, 0.001, 0.008])
def test_the_noise_is_measured_in_motion_and_at_irregular_times(sigma):
    rng = np.random.default_rng(7)
    t = np.cumsum(rng.uniform(0.01, 0.024, 800))
    line = t[:, None] * np.array([0.3, -0.1, 0.2])
    noisy = line + rng.normal(scale=sigma, size=line.shape)
    assert noise(t, noisy) == pytest.approx(sigma, rel=0.1, abs=1e-9)


def test_noise_along_one_axis_alone_is_not_overlooked():
    rng = np.random.default_rng(8)
    path = np.zeros((800, 3))
    path[:, 2] = rng.normal(scale=0.006, size=800)
    assert noise(np.arange(800) / 30, path) == pytest.approx(0.006 / np.sqrt(3), rel=0.1)


@pytest.mark.parametrize("sigma", [0.0, 0.01, 0.05])
def test_the_noise_of_a_turning_body_is_measured(sigma):
    rng = np.random.default_rng(9)
    t = np.arange(800) / 30
    yaw = 0.5 * t + rng.normal(scale=sigma, size=800)
    measured = turn_noise(t, from_yaw(np.zeros((800, 3)), yaw))
    assert measured == pytest.approx(sigma / np.sqrt(3), rel=0.1, abs=1e-6)


def test_a_track_that_repeats_its_last_pose_and_jumps_is_frozen():
    frozen = STEADY.copy()
    frozen[10:20] = frozen[9]
    assert np.flatnonzero(~believable(frozen, ROBUST)).tolist() == list(range(10, 20))


def test_a_turn_that_is_repeated_and_jumps_is_frozen():
    turning = from_yaw(np.zeros((40, 3)), np.arange(40) * 0.05)
    turning[10:20] = turning[9]
    assert np.flatnonzero(~believable(turning, ROBUST)).tolist() == list(range(10, 20))


def test_a_body_that_rests_and_sets_off_is_believed():
    resting = STEADY.copy()
    resting[:20] = resting[19]
    resting[30:] = resting[29]
    assert believable(resting, ROBUST).all()


def test_what_was_not_seen_is_not_known():
    poses = STEADY.copy()
    poses[5:8] = np.nan
    track = track_of(np.arange(40) / 30, poses, ROBUST)
    assert np.flatnonzero(~track.known).tolist() == [5, 6, 7]
    assert track.noise == pytest.approx(0, abs=1e-12)
