"""What is tried around a mean policy, and where the mean goes, whatever the algorithm."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.events import TrialFinished
from imitate.learning.exploration import adapted, first_spread, improved, sample
from imitate.settings import Settings, parse_settings
from imitate.skill import CostTerms, Policy

RNG = 7
MEAN = Policy("green", 2.0, np.eye(7)[6], np.eye(7)[6], np.full((4, 6), 3.0), np.zeros(3))


def settings(exploration: str, **changes: float) -> Settings:
    return parse_settings({"learning": {"exploration": exploration, **changes}})


def trials(s: Settings, count: int, spread=None) -> list[TrialFinished]:
    rng = np.random.default_rng(RNG)
    policies = [sample(MEAN, rng, 1.0, s, spread) for _ in range(count)]
    cost = CostTerms(0, 0, 0)
    return [TrialFinished(1, 0, k, "explore", 0, (p,), cost, False, "", None) for k, p in enumerate(policies)]


@pytest.mark.parametrize("exploration", ["constant", "covariance", "power"])
def test_the_mean_goes_to_the_cheapest_trial(exploration):
    s = settings(exploration, reward_cost=1.0, eliteness=50.0)
    tried = trials(s, 8, first_spread(MEAN, s))
    costs = [100.0] * 7 + [0.0]
    moved = improved(MEAN, tried, costs, s)
    np.testing.assert_allclose(moved.pose_weights, tried[-1].policies[-1].pose_weights, atol=1e-6)
    np.testing.assert_allclose(moved.gripper_weights, tried[-1].policies[-1].gripper_weights, atol=1e-6)
    np.testing.assert_array_equal(moved.goal, MEAN.goal)


@pytest.mark.parametrize("exploration", ["constant", "covariance", "power"])
def test_the_order_of_trials_does_not_matter(exploration):
    s = settings(exploration)
    tried, costs = trials(s, 6, first_spread(MEAN, s)), [5.0, 1.0, 40.0, 12.0, 7.0, 3.0]
    a, b = improved(MEAN, tried, costs, s), improved(MEAN, tried[::-1], costs[::-1], s)
    np.testing.assert_allclose(a.pose_weights, b.pose_weights)
    np.testing.assert_allclose(a.gripper_weights, b.gripper_weights, atol=1e-12)


def test_the_goal_is_learned_where_it_has_noise():
    s = settings("constant", goal_noise=0.03, goal_turn_noise=0.07, eliteness=50.0)
    tried = trials(s, 8)
    moved = improved(MEAN, tried, [100.0] * 7 + [0.0], s)
    np.testing.assert_allclose(moved.goal, tried[-1].policies[-1].goal, atol=1e-6)
    offsets = np.array([t.policies[-1].goal[:3] for t in trials(s, 400)])
    assert offsets.std() == pytest.approx(0.03, rel=0.1)


def test_without_noise_the_goal_stays_and_no_draw_is_made_for_it():
    plain, with_goal = settings("constant"), settings("constant", goal_noise=0.03)
    a, b = (trials(s, 1)[0].policies[-1] for s in (plain, with_goal))
    np.testing.assert_array_equal(a.pose_weights, b.pose_weights)
    np.testing.assert_array_equal(a.goal, MEAN.goal)


def test_the_covariance_starts_as_the_constant_noise_and_narrows_to_what_was_cheap():
    s = settings("covariance", covariance_rate=1.0, least_noise=0.1)
    spread = first_spread(MEAN, s)
    assert spread is not None
    np.testing.assert_allclose(spread.pose[0], (0.02 * 3) ** 2 * np.eye(4))
    np.testing.assert_allclose(spread.gripper, 40.0**2 * np.eye(3))
    tried = trials(s, 300, spread)
    costs = [abs(t.policies[-1].gripper_weights[0]) for t in tried]
    after = adapted(spread, MEAN, tried, costs, s)
    assert after is not None
    assert after.gripper[0, 0] < 0.3 * after.gripper[1, 1]


def test_nothing_is_adapted_where_the_noise_is_constant():
    s = settings("constant")
    assert first_spread(MEAN, s) is None
    assert adapted(None, MEAN, trials(s, 3), [1.0, 2.0, 3.0], s) is None


def test_a_policy_without_a_gripper_is_explored_by_every_algorithm():
    bare = replace(MEAN, gripper_weights=np.zeros(0))
    for exploration in ("constant", "covariance", "power", "per-kernel"):
        s = settings(exploration)
        tried = sample(bare, np.random.default_rng(0), 1.0, s, first_spread(bare, s))
        assert tried.gripper_weights.shape == (0,)
        noise = tried.pose_weights - bare.pose_weights if exploration != "per-kernel" else tried.pose_noise
        assert noise.any()
