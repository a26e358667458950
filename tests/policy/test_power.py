"""PoWER: what must hold whatever the costs."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from imitate.policy.power import power_update, returns

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
    assert not power_update(noise, np.zeros(K)).any()
