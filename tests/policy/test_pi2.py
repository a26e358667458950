"""Policy improvement: what must hold whatever the costs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from imitate.policy.pi2 import (
    constant_update,
    covariance_update,
    noise_factor,
    per_kernel_update,
    per_step_update,
    probabilities,
)

K = 6
costs = arrays(float, K, elements=st.floats(0, 100))
noises = arrays(float, (K, 4, 2), elements=st.floats(-10, 10))


@given(costs)
def test_probabilities_are_a_distribution_that_prefers_the_cheap(s):
    p = probabilities(s, 10.0)
    assert np.isclose(p.sum(), 1)
    assert np.all(np.diff(p[np.argsort(s)]) <= 1e-12)


@given(costs, st.floats(0.1, 10), st.floats(-50, 50))
def test_probabilities_ignore_the_scale_and_origin_of_costs(s, scale, origin):
    if np.ptp(s) > 1e-3:
        assert np.allclose(probabilities(s, 10.0), probabilities(scale * s + origin, 10.0), atol=1e-6)


@given(noises)
def test_equal_costs_move_by_the_mean_of_the_noise_alone(noise):
    assert np.allclose(constant_update(noise, np.full(K, 7.0), 10.0), noise.mean(axis=0))


@given(noises, st.floats(0, 100))
def test_equal_costs_to_go_move_each_kernel_by_the_mean_of_its_noise(noise, cost):
    # Equal between rollouts at each time, not over time.
    activations = np.random.default_rng(0).dirichlet(np.ones(4), 20)
    to_go = np.tile(np.linspace(cost, 0, 20)[:, None], K)
    assert np.allclose(per_kernel_update(noise, to_go, activations, 10.0), noise.mean(axis=0))


@given(noises, arrays(float, (20, K), elements=st.floats(0, 100)), st.permutations(range(K)))
def test_the_order_of_trials_does_not_matter_to_a_kernel(noise, to_go, order):
    activations, order = np.random.default_rng(0).dirichlet(np.ones(4), 20), list(order)
    a, b = (per_kernel_update(noise[k], to_go[:, k], activations, 10.0) for k in (slice(None), order))
    assert np.allclose(a, b)


@given(noises, costs, st.permutations(range(K)))
def test_the_order_of_trials_does_not_matter(noise, s, order):
    order = list(order)
    assert np.allclose(constant_update(noise, s, 10.0), constant_update(noise[order], s[order], 10.0))


@given(noises, costs)
def test_an_update_stays_within_what_was_tried(noise, s):
    change = constant_update(noise, s, 10.0)
    assert np.all(change <= noise.max(axis=0) + 1e-9)
    assert np.all(change >= noise.min(axis=0) - 1e-9)


@given(noises, costs)
def test_per_kernel_with_costs_at_the_end_alone_is_the_constant_update(noise, s):
    activations = np.full((20, 4), 0.25)
    change = per_kernel_update(noise, np.tile(s, (20, 1)), activations, 10.0)
    assert np.allclose(change, constant_update(noise, s, 10.0))


def test_per_kernel_gives_no_credit_for_costs_before_the_kernel_acts():
    # Rollout 0 pays early, rollout 1 late; the last kernel acts after the early cost is past.
    activations = np.zeros((10, 2))
    activations[:5, 0] = activations[5:, 1] = 1
    to_go = np.zeros((10, 2))
    to_go[:2, 0] = 50
    to_go[:, 1] = 10
    noise = np.array([[[1.0], [1.0]], [[-1.0], [-1.0]]])
    assert per_kernel_update(noise, to_go, activations, 10.0)[1, 0] > 0.99


@pytest.mark.parametrize(("update", "expected"), [(0, 0.8), (3, 0.2), (4, 0.1), (9, 0.1)])
def test_noise_narrows_to_its_least(update, expected):
    assert noise_factor(update, 5, 0.1) == pytest.approx(expected)


@given(arrays(float, (K, 3), elements=st.floats(-10, 10)), costs, st.floats(0, 1))
def test_an_adapted_covariance_is_one_and_never_too_narrow(noise, s, rate):
    adapted = covariance_update(np.eye(3), noise, s, 10.0, rate, np.array(0.1))
    np.testing.assert_allclose(adapted, adapted.T, atol=1e-9)
    assert np.linalg.eigvalsh(adapted).min() >= 0.01 - 1e-9


def test_the_covariance_turns_to_where_it_was_cheap():
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((200, 2))
    adapted = covariance_update(np.eye(2), noise, np.abs(noise[:, 0]), 10.0, 1.0, np.array(0.01))
    assert adapted[0, 0] < 0.2 * adapted[1, 1]
    unchanged = covariance_update(np.eye(2), noise, np.abs(noise[:, 0]), 10.0, 0.0, np.array(0.01))
    np.testing.assert_allclose(unchanged, np.eye(2), atol=1e-12)


@given(costs, st.permutations(range(K)))
def test_a_step_is_not_moved_by_the_order_of_rollouts(s, order):
    rng = np.random.default_rng(0)
    noise, acting = rng.normal(size=(K, 5, 3)), rng.dirichlet(np.ones(3), size=5)
    to_go = np.cumsum(np.repeat(s[None], 5, axis=0)[::-1], axis=0)[::-1]
    order = list(order)
    a = per_step_update(noise, to_go, acting, 10.0)
    assert np.allclose(a, per_step_update(noise[order], to_go[:, order], acting, 10.0))


@given(noises)
def test_where_one_kernel_acts_at_a_time_steps_are_kernels(noise):
    # Then the projection changes nothing, and both forms of PI² are one.
    acting = np.repeat(np.eye(4), 3, axis=0)
    to_go = np.random.default_rng(1).uniform(size=(12, K))
    held = np.repeat(noise[:, None, :, 0], 12, axis=1)
    a = per_kernel_update(noise[..., :1], to_go, acting, 10.0)[:, 0]
    assert np.allclose(per_step_update(held, to_go, acting, 10.0), a)


def test_a_kernel_learns_most_from_early_steps_at_which_it_acts():
    # By (N − i) ψ: of four steps, the first counts four times as much as the last.
    acting = np.array([[0.5, 0.5], [1.0, 0.0], [0.0, 1.0], [0.25, 0.75]])
    to_go = np.array([[0.0, 9.0], [9.0, 0.0], [0.0, 9.0], [9.0, 0.0]])  # who is the cheaper of two, in turn
    noise = np.array([[[1.0], [1.0]], [[0.0], [0.0]]])
    found = per_kernel_update(noise, to_go, acting, 1000.0)[:, 0]
    np.testing.assert_allclose(found, [2 / (2 + 3 + 0.25), (2 + 2) / (2 + 2 + 0.75)])


def test_probabilities_are_as_they_are_written_down():
    p = np.exp([0.0, -1.0, -2.0])
    np.testing.assert_allclose(probabilities(np.array([3.0, 5.0, 7.0]), 2.0), p / p.sum())
    np.testing.assert_array_equal(probabilities(np.full((2, 4), 3.0), 9.0), np.full((2, 4), 0.25))


def test_a_covariance_is_the_share_of_the_old_and_of_what_was_cheap_and_of_many_channels_each_its_own():
    rng = np.random.default_rng(2)
    noise, s = rng.normal(size=(K, 2, 3)), rng.uniform(0, 9, K)
    old = np.array([np.eye(3), 4 * np.eye(3)])
    p = probabilities(s, 5.0)
    wanted = [
        0.75 * old[c] + 0.25 * sum(p[k] * np.outer(noise[k, c], noise[k, c]) for k in range(K))
        for c in (0, 1)
    ]
    np.testing.assert_allclose(covariance_update(old, noise, s, 5.0, 0.25, np.zeros(2)), wanted)
    wide = covariance_update(old, noise, s, 5.0, 0.25, np.array([0.0, 30.0]))
    np.testing.assert_allclose(wide[0], wanted[0])
    np.testing.assert_allclose(wide[1], 900 * np.eye(3), atol=1e-9)
