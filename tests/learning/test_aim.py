"""Goals that make up for errors: a correction undoes what it saw, exploration finds where to take hold."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from records import still

from imitate.demonstration import HAND
from imitate.events import OptionLearned, TrialFinished
from imitate.geometry import compose, from_yaw, relative
from imitate.learning import reformulate
from imitate.learning.aim import better_aimed, corrected, shifted
from imitate.learning.improve import Improvement
from imitate.learning.option import Success
from imitate.learning.problem import end_of
from imitate.learning.reformulate import learn_options
from imitate.learning.runs import Learned
from imitate.learning.trials import nothing_is_skipped
from imitate.record import Start
from imitate.settings import Learning, Settings, load_settings
from imitate.skill import CostTerms
from imitate.world.scene import scene_of, shown_start
from imitate.world.trial import Outcome

LEARNING = Learning()


def ending(record, names, body, reference, pose):
    """The record with a body all along at ``pose`` in the reference's frame."""
    poses = record.object_poses.copy()
    poses[:, names.index(body)] = compose(poses[-1, names.index(reference)], pose)
    return replace(record, object_poses=poses)


@given(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03), st.floats(-0.6, 0.6))
def test_the_correction_undoes_what_a_held_body_ended_off(short_demonstration, carry_problem, x, y, yaw):
    # In the hand the body is where it is; were the goal reached as commanded, it would end where shown.
    problem, names = carry_problem, short_demonstration.object_names
    policy = problem.imitated
    end = compose(from_yaw([x, y, 0.0], yaw), problem.shown["cubeA"])
    record = ending(still(short_demonstration), names, "cubeA", "cubeB", end)
    held = relative(policy.goal, end)
    moved = corrected(problem, policy, record, LEARNING)
    assert np.allclose(compose(moved.goal, held)[:3], problem.shown["cubeA"][:3], atol=1e-9)
    assert abs(compose(moved.goal, held)[3:] @ problem.shown["cubeA"][3:]) == pytest.approx(1, abs=1e-9)
    assert np.array_equal(moved.pose_weights, policy.pose_weights)


@pytest.mark.parametrize("off", [from_yaw([0.051, 0, 0], 0.0), from_yaw([0, 0, 0], 0.8)])
def test_a_body_that_was_lost_on_the_way_corrects_nothing(short_demonstration, carry_problem, off):
    names = short_demonstration.object_names
    end = compose(carry_problem.shown["cubeA"], off)
    record = ending(still(short_demonstration), names, "cubeA", "cubeB", end)
    assert corrected(carry_problem, carry_problem.imitated, record, LEARNING) is None


def test_a_skill_that_carries_nothing_is_corrected_by_the_hand(short_demonstration, carry_problem):
    abstraction = replace(carry_problem.formulation.abstraction, relevant=(HAND,))
    problem = replace(
        carry_problem,
        formulation=replace(carry_problem.formulation, abstraction=abstraction),
        shown={HAND: carry_problem.imitated.goal},
    )
    record = still(short_demonstration)
    hand = record.hand_poses.copy()
    hand[:, 0] += 0.012
    record = replace(record, hand_poses=hand)
    moved = corrected(problem, problem.imitated, record, LEARNING)
    off = end_of(problem, record, HAND)[:3] - problem.shown[HAND][:3]
    assert np.linalg.norm(off) == pytest.approx(0.012, abs=1e-6)
    assert np.allclose(moved.goal[:3], problem.imitated.goal[:3] - off, atol=1e-6)


def test_a_goal_is_shifted_and_not_turned(carry_problem):
    goals = [shifted(carry_problem.imitated, np.random.default_rng(k), 0.01).goal for k in range(400)]
    moves = np.array(goals) - carry_problem.imitated.goal
    assert np.allclose(moves[:, :3].std(axis=0), 0.01, rtol=0.15)
    assert not moves[:, 3:].any()


def test_goals_follow_what_was_cheap(carry_problem):
    policy = carry_problem.imitated
    tried = [shifted(policy, np.random.default_rng(k), 0.01) for k in range(50)]
    wanted = policy.goal[:3] + np.array([0.01, -0.01, 0])
    costs = np.array([1e3 * np.linalg.norm(p.goal[:3] - wanted) for p in tried])
    moved = better_aimed(policy, tried, costs, 10.0)
    assert np.linalg.norm(moved.goal[:3] - wanted) < 0.7 * np.linalg.norm(policy.goal[:3] - wanted)


def trial(row, record):
    """One that counts towards P, and succeeds."""
    return TrialFinished(0, 0, 0, "evaluate", 0, row, CostTerms(1.0, 0.0, 0.0), True, "", record)


@dataclass
class Settled:
    """Settings alone: no trial is run."""

    settings: Settings
    spec = SimpleNamespace(description="", robot="panda")


class AtTheEdge:
    """Trials in which the grasp holds where the hand took hold within 8 mm of somewhere else."""

    def __init__(self, demonstration, settings, where):
        self.spec = scene_of(demonstration, settings.world)
        self.settings = settings
        self.record = still(demonstration)
        self.where = where
        self.skip = nothing_is_skipped

    def run(self, tasks):
        for task in tasks:
            grasp, carry = task.policies[-2:]
            closed = carry.gripper_weights.mean() > 0
            missed = max(0.0, float(np.linalg.norm(grasp.goal[:3] - self.where)) - 0.008)
            poses = self.record.object_poses.copy()
            poses[:, 0, 2] += min(0.14, 10 * missed) if closed else 0.14
            record = replace(self.record, object_poses=poses, option_starts=(0, 240)[: len(task.policies)])
            yield Outcome(record)


def learned_at_the_edge(demonstration, problem, seed):
    """What is explored and learned where the hold is 12 mm beside the shown one."""
    settings = load_settings(None, {"learning": {"grasp_noise": 0.01}})
    reach = replace(problem.imitated, gripper_weights=np.zeros(0))
    trials = AtTheEdge(demonstration, settings, reach.goal[:3] + np.array([0.012, 0, 0]))
    sequence = np.random.SeedSequence(seed)
    course = Improvement(problem, (reach,), problem.imitated, trials, sequence)
    explored, run = [], course.run(shown_start(trials.spec))
    while True:
        try:
            event = next(run)
        except StopIteration as end:
            return reach, trials.where, explored, end.value
        if isinstance(event, TrialFinished) and event.purpose == "explore":
            explored.append(event)


def test_where_the_hand_takes_hold_is_learned_with_the_carry(short_demonstration, carry_problem):
    found = 0
    for seed in range(10):
        reach, where, explored, learned = learned_at_the_edge(short_demonstration, carry_problem, seed)
        assert all(len(trial.policies) == 2 for trial in explored)
        if learned.accepted:
            found += 1
            grasp, carry = learned.row
            assert carry is learned.policy
            assert np.linalg.norm(grasp.goal[:3] - where) < 0.012
            assert np.array_equal(grasp.pose_weights, reach.pose_weights)
    assert found >= 7


def test_the_skill_before_takes_the_goal_that_was_learned_for_it(stacking, monkeypatch):
    demonstration, segments = stacking
    settings = load_settings(None, {"learning": {"grasp_noise": 0.01}})

    class Learner:
        def __init__(self, _problem, prefix, mean, *_):
            self.row = (mean,)
            if prefix:
                self.row = (shifted(prefix[-1], np.random.default_rng(1), 0.01), mean)

        def run(self, _):
            record = still(demonstration)
            record = replace(record, option_starts=(0, 240)[: len(self.row)])
            yield trial(self.row, record)
            return Learned(self.row, 1.0, Success(20, 20), 1.0, 1.0, True)

    monkeypatch.setattr(reformulate, "Improvement", Learner)
    run = learn_options(demonstration, segments, Settled(settings), Start([0.0], [[0.0] * 7]), 0)
    events = []
    while True:
        try:
            events.append(next(run))
        except StopIteration as end:
            search = end.value
            break
    learned = [event for event in events if isinstance(event, OptionLearned)]
    assert [event.segment for event in learned] == [0, 0, 1]
    off = np.linalg.norm(learned[1].policy.goal[:3] - learned[0].policy.goal[:3])
    assert [event.moved for event in learned] == [0.0, pytest.approx(off), 0.0]
    assert search.options[0].policy is learned[1].policy
    assert len(search.options[0].ends) == 1
