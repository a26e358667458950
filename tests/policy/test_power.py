"""PoWER: what must hold whatever the costs."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from imitate.policy.power import power_update, power_update_in_time, returns

K = 6
costs = arrays(float, K, elements=st.floats(0, 100))
noises = arrays(float, (K, 4, 2), elements=st.floats(-10, 10))


@given(costs)
def test_rewards_are_highest_where_the_cost_is_lowest(s):
    rewards = returns(s, 20.0)
    assert np.all((rewards > 0) & (rewards <= 1))
    assert rewards[np.argmin(s)] == rewards.max()


@given(noises, costs, st.floats(0, 50))
def test_a_cost_that_all_share_changes_nothing(noise, s, extra):
    a, b = (power_update(noise, returns(c, 20.0)) for c in (s, s + extra))
    np.testing.assert_allclose(a, b, atol=1e-9)


@given(noises, costs, st.permutations(range(K)))
def test_the_order_of_trials_does_not_matter(noise, s, order):
    order = list(order)
    a, b = power_update(noise, returns(s, 20.0)), power_update(noise[order], returns(s[order], 20.0))
    np.testing.assert_allclose(a, b, atol=1e-9)


@given(noises)
def test_nothing_rewarded_moves_nothing(noise):
    still = power_update(noise, np.zeros(K))
    assert still.shape == noise.shape[1:]
    assert not still.any()
    assert not power_update(noise, np.full(K, -1.0)).any()


def test_a_reward_is_e_to_the_minus_cost_over_scale():
    np.testing.assert_allclose(returns([0, 20, 40], 20.0), np.exp([0.0, -1.0, -2.0]))


def test_in_time_it_is_the_sum_over_rollouts_and_steps_that_is_written_down():
    rng = np.random.default_rng(3)
    noise, variances = rng.normal(size=(K, 4)), rng.uniform(0.5, 2, (K, 4))
    acting, to_go = rng.dirichlet(np.ones(4), 9), rng.uniform(0.1, 1, (9, K))
    above, below = np.zeros(4), np.zeros(4)
    for k in range(K):
        for psi, gain in zip(acting, to_go[:, k], strict=True):
            w = psi**2 / (psi @ (variances[k] * psi))
            above += w * noise[k] * gain
            below += w * gain
    np.testing.assert_allclose(power_update_in_time(noise, to_go, acting, variances), above / below)
    half = power_update_in_time(noise, to_go, acting, variances, least=below)
    np.testing.assert_allclose(half, above / below / 2)


@given(arrays(float, (K, 4), elements=st.floats(-10, 10)), st.floats(0.1, 10))
def test_in_time_where_all_kernels_act_alike_it_is_the_mean_weighted_by_returns(noise, deviation):
    reward_to_go = np.random.default_rng(0).uniform(0.1, 1, (1, K))
    acting, variances = np.full((1, 4), 0.25), np.full((K, 4), deviation**2)
    found = power_update_in_time(noise, reward_to_go, acting, variances)
    assert np.allclose(found, power_update(noise, reward_to_go[0]), atol=1e-6)


def test_in_time_a_kernel_learns_only_from_rewards_that_follow_it():
    noise, acting = np.array([[1.0, 0.0], [0.0, 1.0]]), np.eye(2)
    reward_to_go = np.array([[1.0, 1.0], [0.0, 1.0]])  # the first rollout is worth nothing once 1 acts
    found = power_update_in_time(noise, reward_to_go, acting, np.ones((2, 2)))
    assert np.allclose(found, [0.5, 1.0])
