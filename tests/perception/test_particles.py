"""The annealed filter finds a peak, repeats itself, and says how sure it is."""

import numpy as np
import pytest

from imitate.geometry import angle_between
from imitate.perception.particles import anneal, moved


def test_finds_a_narrow_peak_away_from_the_first_particles():
    peak = np.array([0.02, -0.01, 0.015])

    def score(particles):
        return (-np.sum((particles - peak) ** 2, axis=1) / (2 * 0.0002**2)).astype(np.float32)

    first = 0.01 * np.random.default_rng(0).standard_normal((150, 3))
    best = anneal(first, score, 10, np.random.default_rng(1))
    assert np.linalg.norm(best.mean - peak) < 0.001
    again = anneal(first, score, 10, np.random.default_rng(1))
    np.testing.assert_array_equal(best.mean, again.mean)
    assert np.all(best.deviation < 0.002)


def test_moved_shifts_and_turns():
    base = np.array([0.1, 0.2, 0.3, 0, 0, np.sin(0.2), np.cos(0.2)])
    poses = moved(base, np.array([[0.0, 0, 0, 0, 0, 0], [0.01, 0, -0.02, 0.1, 0, 0.2]]))
    np.testing.assert_allclose(poses[0], base)
    np.testing.assert_allclose(poses[1, :3], [0.11, 0.2, 0.28])
    assert angle_between(base, poses[1]) == pytest.approx(np.hypot(0.1, 0.2))
