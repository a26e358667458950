"""What is tried around a mean policy, and where the mean goes, whatever the algorithm."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from records import gripping

from imitate.events import TrialFinished
from imitate.geometry import normalised
from imitate.learning.exploration import adapted, cost_to_go, first_spread, improved, sample
from imitate.settings import Settings, parse_settings
from imitate.skill import CostTerms, Policy

RNG = 7
MEAN = Policy("green", 2.0, np.eye(7)[6], np.eye(7)[6], np.full((4, 6), 3.0), np.zeros(3))


ALL = ("constant", "covariance", "power", "per-kernel")


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


def test_the_mean_goes_to_the_trial_with_the_cheapest_end_with_noise_per_kernel(perfect):
    # Only the terminal cost tells the trials apart: it belongs to the cost to go from every tick on.
    s = settings("per-kernel", eliteness=50.0)
    tried = recorded(trials(s, 8), perfect, [100.0] * 7 + [0.0], [-1] * 8)
    moved, best = improved(MEAN, tried, [0.0] * 8, s), tried[-1].policies[-1]
    np.testing.assert_allclose(moved.pose_weights, MEAN.pose_weights + best.pose_noise, atol=1e-6)
    np.testing.assert_allclose(moved.gripper_weights, MEAN.gripper_weights + best.gripper_noise, atol=1e-6)
    np.testing.assert_array_equal(moved.goal, MEAN.goal)


def test_with_noise_per_kernel_each_kernel_learns_from_what_its_own_time_and_later_cost(perfect):
    # The first trial switches in the middle, the second at the end: before both, they cost the same.
    s = settings("per-kernel", eliteness=50.0)
    tried = recorded(trials(s, 2), perfect, [0.0, 0.0], [60, 119])
    first, second = (trial.policies[-1].pose_noise for trial in tried)
    change = improved(MEAN, tried, [0.0, 0.0], s).pose_weights - MEAN.pose_weights
    share = (change - second) / (first - second)  # of the first trial, of each kernel
    assert share[0] == pytest.approx(0.5, abs=0.1)
    assert np.all(np.diff(share[:, 0]) > 0)
    assert share[-1] == pytest.approx(1, abs=0.01)


def test_the_cost_to_go_is_the_terminal_cost_and_what_is_still_to_be_paid(perfect):
    s = settings("per-kernel")
    (trial,) = recorded(trials(s, 1), perfect, [7.0], [30])
    went = cost_to_go(trial, s)
    assert went.shape == (120,)
    np.testing.assert_allclose(went[:31], 7 + s.learning.switch_cost)
    np.testing.assert_allclose(went[31:], 7)
    with pytest.raises(ValueError, match="a trial without its record has no costs in time"):
        cost_to_go(replace(trial, record=None), s)


def test_a_movement_cut_short_cost_nothing_more_after_its_end_and_the_rest_after_it_does_not_count(perfect):
    s = settings("per-kernel")
    (trial,) = recorded(trials(s, 1), perfect, [7.0], [30])
    longer, shorter = (replace(trial, policies=(replace(MEAN, duration=t),)) for t in (3.0, 1.0))
    assert cost_to_go(longer, s).shape == (180,)
    np.testing.assert_allclose(cost_to_go(longer, s)[120:], 7)
    assert cost_to_go(longer, s)[30] == 7 + s.learning.switch_cost
    np.testing.assert_array_equal(cost_to_go(shorter, s), cost_to_go(trial, s)[:60])


def test_with_noise_per_kernel_the_pose_learns_from_its_movement_and_not_from_the_wait_before(perfect):
    # Both trials switch while they wait, one of them twice: only what the gripper did differs.
    s = settings("per-kernel", eliteness=50.0)
    waits = [replace(t, policies=(replace(t.policies[-1], wait=0.5, duration=1.5),)) for t in trials(s, 2)]
    first, second = recorded(waits, perfect, [0.0, 0.0], [3, 3])
    commands = second.record.commands[:, -1].copy()
    commands[6:9] = 0.0
    second = replace(second, record=gripping(perfect, commands))
    mean = replace(MEAN, wait=0.5, duration=1.5)
    assert cost_to_go(first, s).shape == (120,)
    moved = improved(mean, [first, second], [0.0, 0.0], s)
    noise = [trial.policies[-1] for trial in (first, second)]
    np.testing.assert_allclose(
        moved.pose_weights - mean.pose_weights, np.mean([p.pose_noise for p in noise], axis=0), atol=1e-9
    )
    change, (a, b) = moved.gripper_weights - mean.gripper_weights, (p.gripper_noise for p in noise)
    assert (change[0] - b[0]) / (a[0] - b[0]) > 0.51


@pytest.mark.parametrize("exploration", ["constant", "power", "per-kernel"])
def test_the_factor_scales_all_noise_alike(exploration):
    s = settings(exploration, **GOAL)
    whole, third = (sample(MEAN, np.random.default_rng(RNG), f, s) for f in (1.0, 1 / 3))
    for field in ("pose_weights", "gripper_weights", "pose_noise", "gripper_noise"):
        there, less = getattr(whole, field), getattr(third, field)
        centre = getattr(MEAN, field) if field.endswith("weights") else 0.0
        np.testing.assert_allclose(less - centre, (there - centre) / 3, atol=1e-12, err_msg=field)
    off, nearer = (policy.goal[:3] - MEAN.goal[:3] for policy in (whole, third))
    np.testing.assert_allclose(nearer, off / 3, atol=1e-12)
    assert whole.gripper_weights.any() or whole.gripper_noise.any()


GOAL = {"goal_noise": 0.03, "goal_turn_noise": 0.07}


def recorded(tried: list[TrialFinished], record, terminal, switched) -> list[TrialFinished]:
    """The trials with these terminal costs, the gripper of each closed from the given tick on (-1: never)."""
    closed = [np.arange(len(record.commands)) >= (k if k >= 0 else np.inf) for k in switched]
    return [
        replace(trial, cost=CostTerms(cost, 0, 0), record=gripping(record, 20.0 * shut))
        for trial, cost, shut in zip(tried, terminal, closed, strict=True)
    ]


@pytest.mark.parametrize("exploration", ALL)
@given(order=st.permutations(range(6)))
def test_the_order_of_trials_does_not_matter(exploration, perfect, order):
    s = settings(exploration, **GOAL)
    spread, costs = first_spread(MEAN, s), [5.0, 1.0, 40.0, 12.0, 7.0, 3.0]
    tried = recorded(trials(s, 6, spread), perfect, costs, [-1, 0, 30, 60, 90, 119])
    mixed, their = [tried[k] for k in order], [costs[k] for k in order]
    a, b = improved(MEAN, tried, costs, s), improved(MEAN, mixed, their, s)
    for field in ("pose_weights", "gripper_weights", "goal"):
        np.testing.assert_allclose(getattr(a, field), getattr(b, field), rtol=1e-9, atol=1e-9)
        assert not np.allclose(getattr(a, field), getattr(MEAN, field))
    c, d = (adapted(spread, MEAN, *of, s) for of in ((tried, costs), (mixed, their)))
    if c is not None and d is not None:
        np.testing.assert_allclose(c.pose, d.pose, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(c.gripper, d.gripper, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("exploration", ALL)
@given(cost=st.floats(0, 200), tick=st.integers(-1, 119))
def test_equal_costs_move_by_the_mean_of_the_noise_alone(exploration, perfect, cost, tick):
    s = settings(exploration, **GOAL)
    spread = first_spread(MEAN, s)
    tried = recorded(trials(s, 6, spread), perfect, [cost] * 6, [tick] * 6)
    policies = [trial.policies[-1] for trial in tried]
    moved = improved(MEAN, tried, [cost] * 6, s)
    noise = [p.pose_weights + (p.pose_noise if len(p.pose_noise) else 0) for p in policies]
    squeeze = [p.gripper_weights + (p.gripper_noise if len(p.gripper_noise) else 0) for p in policies]
    np.testing.assert_allclose(moved.pose_weights, np.mean(noise, axis=0), atol=1e-9)
    np.testing.assert_allclose(moved.gripper_weights, np.mean(squeeze, axis=0), atol=1e-9)
    np.testing.assert_allclose(moved.goal, normalised(np.mean([p.goal for p in policies], axis=0)), atol=1e-9)


@pytest.mark.parametrize("exploration", ALL)
def test_equal_costs_of_opposite_noise_move_nothing(exploration, perfect):
    s = settings(exploration)
    there = trials(s, 5, first_spread(MEAN, s))
    back = [replace(t, policies=(mirrored(t.policies[-1]),)) for t in there]
    tried = recorded([*there, *back], perfect, [30.0] * 10, [40] * 10)
    moved = improved(MEAN, tried, [30.0] * 10, s)
    np.testing.assert_allclose(moved.pose_weights, MEAN.pose_weights, atol=1e-9)
    np.testing.assert_allclose(moved.gripper_weights, MEAN.gripper_weights, atol=1e-9)


def mirrored(policy: Policy) -> Policy:
    """The policy on the other side of the mean."""
    return replace(
        policy,
        pose_weights=2 * MEAN.pose_weights - policy.pose_weights,
        gripper_weights=2 * MEAN.gripper_weights - policy.gripper_weights,
        pose_noise=-policy.pose_noise,
        gripper_noise=-policy.gripper_noise,
    )


def test_equal_costs_leave_a_covariance_to_the_spread_that_was_tried():
    s = settings("covariance", covariance_rate=0.3, least_noise=0.0)
    spread = first_spread(MEAN, s)
    assert spread is not None
    tried = trials(s, 6, spread)
    after = adapted(spread, MEAN, tried, [9.0] * 6, s)
    assert after is not None
    noise = np.array([t.policies[-1].gripper_weights for t in tried])
    np.testing.assert_allclose(after.gripper, 0.7 * spread.gripper + 0.3 * noise.T @ noise / 6, atol=1e-9)


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
    s = settings("covariance", covariance_rate=1.0, gripper_noise=40.0, gripper_smoothness=0.0)
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


@pytest.mark.parametrize("exploration", ["constant", "covariance"])
@pytest.mark.parametrize("smoothness", [0.0, 2.0, 4.0])
def test_the_grippers_noise_is_as_strong_and_as_smooth_as_asked(exploration, smoothness):
    neighbours = np.exp(-1 / smoothness) if smoothness else 0.0
    s = settings(exploration, gripper_smoothness=smoothness, gripper_noise=40.0)
    rng, mean = np.random.default_rng(RNG), replace(MEAN, gripper_weights=np.zeros(5))
    spread = first_spread(mean, s)
    drawn = np.array([sample(mean, rng, 1.0, s, spread).gripper_weights for _ in range(4000)])
    np.testing.assert_allclose(drawn.std(axis=0), 40.0, rtol=0.05)
    correlation = np.corrcoef(drawn.T)
    np.testing.assert_allclose(np.diag(correlation, 1), neighbours, atol=0.05)
    np.testing.assert_allclose(correlation[0, 4], neighbours**4, atol=0.05)


def test_rewards_weigh_trials_otherwise_than_their_order_of_costs():
    costs = [10.0, 20.0, 30.0, 40.0]
    means = []
    for exploration in ("power", "constant"):
        s = settings(exploration)
        means.append(improved(MEAN, trials(s, 4), costs, s).pose_weights)
    assert np.abs(means[0] - means[1]).max() > 1e-3
