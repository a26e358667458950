"""The baseline has the textbook's likelihood and its paper's sums, and cuts a carry that slows down."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_t
from stacking import Stacking, perform

from imitate.geometry import relative
from imitate.segmentation import posteriors, segment
from imitate.segmentation.cst import (
    NOISE_SCALE,
    NOISE_SHAPE,
    REWARD,
    WEIGHT_VARIANCE,
    CstScore,
    fourier,
    log_likelihood,
)
from imitate.settings import load_settings

CST = load_settings(overrides={"mode": "cst"}).segmentation


def incremental(features, rewards, discount):
    """A, b and ΣR² by the updates of Konidaris et al., a frame at a time."""
    m = features.shape[1]
    a, b, z, squares, trace1, trace2 = np.zeros((m, m)), np.zeros(m), np.zeros(m), 0.0, 0.0, 0.0
    for f, r in zip(features, rewards, strict=True):
        a += np.outer(f, f)
        z = discount * z + f
        b = b + r * z
        trace1 = 1 + discount**2 * trace1
        squares += r**2 * trace1 + 2 * discount * r * trace2
        trace2 = discount * trace2 + r * trace1
    return a, b, squares


@settings(deadline=None, max_examples=30)
@given(frames=st.integers(1, 40), discount=st.floats(0.5, 1), seed=st.integers(0, 2**32 - 1))
def test_the_updates_add_up_to_the_returns(frames, discount, seed):
    rng = np.random.default_rng(seed)
    features, rewards = rng.normal(size=(frames, 4)), rng.normal(size=frames)
    returns = np.zeros(frames + 1)
    for i in reversed(range(frames)):
        returns[i] = rewards[i] + discount * returns[i + 1]
    a, b, squares = incremental(features, rewards, discount)
    assert a == pytest.approx(features.T @ features)
    assert b == pytest.approx(features.T @ returns[:-1])
    assert squares == pytest.approx(returns @ returns)


@settings(deadline=None, max_examples=20)
@given(start=st.integers(0, 60), length=st.integers(1, 60), seed=st.integers(0, 2**32 - 1))
def test_a_segment_scores_as_by_the_updates(start, length, seed):
    demonstration, _ = perform(Stacking(noise=0.002), np.random.default_rng(seed))
    found = CstScore(demonstration, 30.0).between(start, start + length).free[0, 0]
    for k, name in enumerate(demonstration.object_names):
        features = fourier(relative(demonstration.pose_of(name), demonstration.hand)[:, :3])
        within = features[start : start + length]
        a, b, squares = incremental(within, np.full(length, REWARD), 1.0)
        expected = log_likelihood(a, b, np.array(squares), np.array(length))
        assert found[k] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("frames", [1, 5, 30])
def test_the_likelihood_is_students(frames):
    rng = np.random.default_rng(frames)
    phi, returns = rng.normal(size=(frames, 3)), rng.normal(scale=20, size=frames)
    spread = NOISE_SCALE / NOISE_SHAPE * (np.eye(frames) + WEIGHT_VARIANCE * phi @ phi.T)
    expected = multivariate_t(np.zeros(frames), spread, df=NOISE_SHAPE).logpdf(returns)
    found = log_likelihood(phi.T @ phi, phi.T @ returns, returns @ returns, np.array(frames))
    assert found == pytest.approx(expected, rel=1e-4)


def test_the_basis_is_scaled_to_what_was_shown():
    x = np.random.default_rng(0).normal(size=(50, 3)) * [1, 100, 0] + [0, 7, 5]
    phi = fourier(x)
    assert phi.shape == (50, 10)
    assert np.abs(phi).max() <= 1
    assert phi[np.argmin(x[:, 1]), 2] == pytest.approx(1)
    assert phi[np.argmax(x[:, 1]), 2] == pytest.approx(-1)


@pytest.mark.parametrize("seed", range(3))
def test_a_carry_is_cut_where_it_slows_down(seed):
    slow = 1.0
    demonstration, (lift, _) = perform(Stacking(noise=0.003, mid_pause=slow), np.random.default_rng(seed))
    segments = segment(demonstration, CST)
    begins = lift + 0.7
    inside = [s.start for s in segments if begins - 0.1 <= s.start <= begins + slow + 0.1]
    assert len(inside) >= 1
    assert len(segments) >= 4
    assert all(s.abstraction.relevant == ("hand",) for s in segments)
    assert all(a.end == b.start for a, b in pairwise(segments))


def test_the_rate_does_not_matter():
    demonstration, _ = perform(Stacking(mid_pause=0.5), np.random.default_rng(1))
    finer, _ = perform(Stacking(mid_pause=0.5, rate=90.0), np.random.default_rng(1))
    expected = [s.start for s in segment(demonstration, CST)]
    assert [s.start for s in segment(finer, CST)] == pytest.approx(expected, abs=0.1)


def test_its_boundaries_have_posteriors():
    demonstration, _ = perform(Stacking(mid_pause=0.5, speed=2.0), np.random.default_rng(1))
    segments = segment(demonstration, CST)
    found = posteriors(demonstration, segments, CST)
    assert [p.probability.sum() for p in found.boundaries] == pytest.approx([1] * (len(segments) - 1))
