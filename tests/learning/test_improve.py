"""One formulation learned in a made-up world, where a grip that is firm enough places the block."""

from collections import Counter
from dataclasses import replace
from itertools import count, groupby

import numpy as np
import pytest
from records import moved, still

from imitate.events import Converged, Evaluated, PolicyUpdated, Skipped, TrialFinished
from imitate.learning import runs
from imitate.learning.improve import Improvement
from imitate.learning.option import Success
from imitate.learning.places import Place
from imitate.learning.trials import nothing_is_skipped
from imitate.record import Sightings
from imitate.settings import load_settings
from imitate.skill import Abstraction
from imitate.world.scene import scene_of, shown_start
from imitate.world.trial import Outcome


class Pretended:
    """Trials whose block ends ``miss(policy)`` metres from its place; ``watch`` makes sightings.

    It is there from the beginning, unless it is moved there ``late``.
    """

    def __init__(self, demonstration, settings, miss, watch=None, skip=nothing_is_skipped, late=False):
        self.late = late
        self.watch = watch
        self.spec = scene_of(demonstration, settings.world)
        self.settings = settings
        self.record = still(demonstration)
        self.miss = miss
        self.skip = skip

    def run(self, tasks):
        for task in tasks:
            policy = task.policies[-1]
            record = moved(self.record, 0, [0, 0, self.miss(policy)])
            if self.late:
                poses = np.concatenate([self.record.object_poses[:100], record.object_poses[100:]])
                record = replace(record, object_poses=poses)
            yield Outcome(record, seen=self.watch(record) if self.watch else None)


def force(policy):
    """Mean gripper weight, noise included."""
    weights = policy.gripper_weights
    noise = policy.gripper_noise
    return float(np.mean(weights + noise if len(noise) else weights)) if len(weights) else 0.0


def held_from(newtons):
    """A block that is left behind the farther the weaker the grip."""
    return lambda policy: 0.14 * float(np.clip(1 - force(policy) / newtons, 0, 1))


@pytest.fixture
def learn(short_demonstration, carry_problem):
    """Runs the improvement; returns the events and what was learned."""

    def run(
        miss,
        gripper=True,
        seed=0,
        prefix=(),
        watch=None,
        skip=nothing_is_skipped,
        problem=carry_problem,
        late=False,
        **learning,
    ):
        settings = load_settings(None, {"mode": learning.pop("mode", "robust"), "learning": learning})
        trials = Pretended(short_demonstration, settings, miss, watch, skip, late)
        imitated = problem.imitated
        mean = imitated if gripper else replace(imitated, gripper_weights=np.zeros(0))
        sequence = np.random.SeedSequence(seed)
        course = Improvement(problem, prefix, mean, trials, sequence).run(shown_start(trials.spec))
        events = []
        while True:
            try:
                events.append(next(course))
            except StopIteration as end:
                return events, end.value

    return run


def resting_at(pose):
    """cubeA, which an earlier skill has put at a pose (7,) relative to cubeB."""
    return Place(0, "cubeA", "carried", "cubeB", pose, 0.02, np.inf, 0.0, 0.0, False, None)


def leaving(carry_problem, placed):
    """The problem of a hand that carries nothing and ends where that of the carry does."""
    alone = Abstraction(("hand",), "cubeB")
    formulation = replace(carry_problem.formulation, abstraction=alone)
    shown = {"hand": carry_problem.imitated.goal}
    return replace(carry_problem, formulation=formulation, shown=shown, placed=placed)


def explored(events):
    return [e for e in events if isinstance(e, TrialFinished) and e.purpose == "explore"]


def test_an_imitation_that_will_do_is_not_explored(learn):
    events, learned = learn(lambda _: 0.0, curtail=False)
    assert len(explored(events)) == 1
    assert learned.accepted
    assert (learned.success.successes, learned.success.trials) == (20, 20)


def test_without_the_gripper_it_converges_and_p_is_zero(learn):
    events, learned = learn(held_from(20.0), gripper=False)
    assert any(isinstance(e, Converged) for e in events)
    assert (learned.success.successes, learned.accepted) == (0, False)
    failures = [e.failure for e in events if isinstance(e, TrialFinished) and e.purpose == "evaluate"]
    assert all(failure.startswith("cubeA ends 140 mm") for failure in failures)


@pytest.mark.parametrize("seed", range(5))
def test_with_the_gripper_a_grip_is_found_within_the_budget(learn, seed):
    events, learned = learn(held_from(20.0), seed=seed)
    assert learned.accepted
    assert force(learned.policy) >= 15
    assert len(explored(events)) <= 30


def test_no_formulation_takes_more_than_thirty_trials(learn):
    events, learned = learn(held_from(1e6))
    assert len(explored(events)) == 30
    assert not learned.accepted


def test_a_success_at_the_edge_of_the_tolerance_is_improved_further(learn):
    # 18 mm off is within 2 cm but not within the margin; a stronger grip is better.
    events, learned = learn(lambda p: 0.018 * float(np.clip(1 - force(p) / 20, 0, 1)), seed=1)
    judged = [e for e in events if isinstance(e, Evaluated)]
    assert [e.accepted for e in judged[:1]] == [False]
    assert learned.accepted
    assert learned.firm == 1.0


def test_what_an_earlier_skill_placed_need_not_be_firmly_so(learn, carry_problem):
    # 18 mm off again, which a skill that only leaves cannot mend.
    where = carry_problem.shown["cubeA"]
    placed = (resting_at(where),)
    retreat = leaving(carry_problem, placed)
    events, learned = learn(lambda _: 0.018, gripper=False, problem=retreat)
    assert (len(explored(events)), learned.accepted, learned.firm) == (1, True, 1.0)
    assert not learn(lambda _: 0.022, gripper=False, problem=retreat)[1].accepted


@pytest.mark.parametrize("knocked", [False, True])
def test_what_was_off_before_it_began_does_not_make_a_skill_explore(learn, carry_problem, knocked):
    # Every tenth trial fails, as the block was set down 30 mm off, or is knocked there by the skill itself.
    number = count()
    where = carry_problem.shown["cubeA"]
    placed = (resting_at(where),)
    retreat = leaving(carry_problem, placed)

    def miss(_policy):
        return 0.03 * (next(number) % 10 == 9)

    events, learned = learn(miss, gripper=False, problem=retreat, late=knocked, curtail=False)
    assert learned.accepted
    assert (learned.success.successes, learned.success.trials) == (18, 20)
    assert (len(explored(events)) > 1) == knocked


def test_the_last_judgement_decides(learn):
    for miss in (held_from(20.0), held_from(1e6), lambda _: 0.018):
        events, learned = learn(miss)
        last = [e for e in events if isinstance(e, Evaluated)][-1]
        assert last is events[-1]
        assert (last.successes, last.accepted) == (learned.success.successes, learned.accepted)


def test_the_same_seed_explores_the_same_policies(learn):
    def noise(seed):
        return [e.policies[-1].gripper_weights for e in explored(learn(held_from(1e6), seed=seed)[0])]

    a, b, c = noise(0), noise(0), noise(1)
    assert all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))
    assert not all(np.array_equal(x, y) for x, y in zip(a, c, strict=True))


def test_exploration_starts_where_the_accepted_skills_end(learn, carry_problem):
    events, _ = learn(lambda _: 0.0, prefix=(carry_problem.imitated,))
    prepare, first = [e for e in events if isinstance(e, TrialFinished)][:2]
    assert prepare.purpose == "prepare"
    assert len(prepare.policies) == 1
    assert first.purpose == "explore"
    judged = [e for e in events if isinstance(e, TrialFinished) and e.purpose == "evaluate"]
    assert {len(e.policies) for e in judged} == {2}


def test_the_faithful_mode_judges_the_mean_policy_alone(learn):
    events, learned = learn(held_from(1e6), mode="faithful")
    updates = [e for e in events if isinstance(e, PolicyUpdated)]
    purposes = {e.purpose for e in events if isinstance(e, TrialFinished)}
    assert purposes == {"explore", "evaluate"}
    assert len(explored(events)[-1].policies[-1].gripper_noise) == 5
    assert np.array_equal(learned.policy.pose_weights, updates[-1].policy.pose_weights)


def test_per_kernel_noise_learns_a_grip_too(learn):
    events, _ = learn(held_from(20.0), mode="faithful", converged_below=0.0, seed=2)
    means = [force(e.policy) for e in events if isinstance(e, PolicyUpdated)]
    assert max(means) > 10


def test_learning_goes_on_where_the_starts_do_not_tell_whether_p_reaches_alpha(learn):
    def one_in(n):
        tasks = count()
        return lambda _: 0.1 if next(tasks) % n == 0 else 0.0

    settings = {"evaluation_starts": 10, "candidate_starts": 2, "sure": 1.0, "converged_below": 0.0}
    events, learned = learn(one_in(4), more_updates=3, **settings)
    low, high = learned.success.interval
    assert low < 0.8 < high
    assert len(explored(events)) == 45
    events, _ = learn(one_in(4), more_updates=0, **settings)
    assert len(explored(events)) == 30


def failing(*which):
    """Trials of which, in any five in a row, as many fail."""
    tasks = count()
    return lambda _: 0.1 if next(tasks) % 5 in which else 0.0


def test_what_wins_as_often_as_alpha_asks_is_judged_and_ends_where_nothing_improves(learn):
    events, learned = learn(failing(0), gripper=False)
    assert (learned.success.successes, learned.accepted) == (16, True)
    assert len(explored(events)) <= 15


def test_a_grip_that_holds_often_enough_and_not_always_is_improved_further(learn):
    events, learned = learn(failing(0))
    assert (learned.success.successes, learned.accepted) == (16, True)
    assert len(explored(events)) == 40


def test_two_failures_in_twenty_are_too_many_to_be_accepted_at_once(learn):
    tasks = count()
    events, learned = learn(lambda _: 0.1 if next(tasks) % 10 == 7 else 0.0)
    first = next(e for e in events if isinstance(e, Evaluated))
    assert (first.successes, first.accepted) == (18, False)
    assert len(explored(events)) > 1
    assert learned.accepted


def test_the_best_of_several_is_judged_on_starts_that_did_not_choose_it(learn, monkeypatch):
    keys = []
    drawn = runs.perturbed_starts

    def watched(spec, count, seed, settings):
        keys.append((count, seed.spawn_key))
        return drawn(spec, count, seed, settings)

    monkeypatch.setattr(runs, "perturbed_starts", watched)
    events, learned = learn(failing(0))
    judged = [key for count, key in keys if count == 20]
    assert judged[-1] not in judged[:-1] and len(judged) > 1
    last = [e for e in events if isinstance(e, TrialFinished) and e.purpose == "evaluate"][-20:]
    assert learned.success.successes == sum(e.success for e in last)


def test_one_that_drops_what_it_carries_is_taken_only_where_nothing_better_is_found(learn, monkeypatch):
    monkeypatch.setattr(runs, "fell", lambda *_: True)
    events, learned = learn(lambda _: 0.0)
    assert len(explored(events)) > 10
    assert learned.accepted
    assert learned.firm == 0


def test_all_who_compete_do_so_in_one_batch_for_the_cores_to_share(learn, monkeypatch):
    batches, run = [], Pretended.run

    def noted(self, tasks):
        batches.append(len(tasks))
        return run(self, tasks)

    monkeypatch.setattr(Pretended, "run", noted)
    events, _ = learn(held_from(20.0))
    purposes = groupby(e.purpose for e in events if isinstance(e, TrialFinished))
    rounds = [len(list(trials)) for purpose, trials in purposes if purpose == "choose"]
    assert max(rounds) > load_settings().learning.candidate_starts
    assert set(rounds) <= set(batches)


def test_what_nearly_won_is_gone_on_with_and_judged_in_the_end(learn):
    events, learned = learn(failing(0, 2), curtail=False)
    assert len(explored(events)) == 40
    assert (learned.success.successes, learned.accepted) == (12, False)
    judged = [e for e in events if isinstance(e, TrialFinished) and e.purpose == "evaluate"]
    chosen = [e.policies[-1] for e in events if isinstance(e, TrialFinished) and e.purpose == "choose"]
    assert len(judged) == 20
    assert any(policy is judged[0].policies[-1] for policy in chosen)


def seen_as(shift=0.0, lost=False):
    """Sightings of a record, the block ``shift`` metres higher than it is, or lost in the last look."""

    def watch(record):
        poses = record.object_poses[[0, -1]].copy()
        poses[:, 0, 2] += shift
        if lost:
            poses[-1, 0] = np.nan
        return Sightings(record.start.objects, (0, record.steps), poses)

    return watch


def test_what_was_seen_is_believed_against_the_physics(learn):
    _, mistaken = learn(lambda _: 0.1, watch=seen_as(shift=-0.1))
    assert mistaken.accepted
    events, misled = learn(lambda _: 0.0, watch=seen_as(shift=0.1))
    assert not misled.accepted
    assert events[0].failure.startswith("cubeA ends 100 mm")


def test_a_block_lost_from_sight_at_the_end_is_a_failure_that_says_so(learn):
    events, learned = learn(lambda _: 0.0, watch=seen_as(lost=True))
    assert {e.failure for e in explored(events)} == {"cubeA was not seen at the end"}
    assert all(np.isfinite(e.cost.total) for e in explored(events))
    assert not learned.accepted


def test_each_trial_is_watched_with_chance_of_its_own(short_demonstration, carry_problem):
    settings = load_settings()
    trials = Pretended(short_demonstration, settings, lambda _: 0.0)
    asked = []
    run = trials.run
    trials.run = lambda tasks: asked.extend(tasks) or run(tasks)
    course = Improvement(carry_problem, (), carry_problem.imitated, trials, np.random.SeedSequence(1))
    for _ in course.run(shown_start(trials.spec)):
        pass
    keys = [task.seed.spawn_key for task in asked]
    assert len(keys) > 20
    assert len(set(keys)) == len(keys)
    assert {task.seed.entropy for task in asked} == {1}


@pytest.mark.parametrize(("miss", "successes"), [(0.2, 0), (0.0, 20)])
def test_what_the_operator_skips_is_judged_once_and_not_accepted(learn, miss, successes):
    asked = []

    def skip(segment, formulation):
        asked.append((segment, formulation))
        return len(asked) == 2

    events, learned = learn(lambda _: miss, skip=skip, candidates=0, converged_below=0.0, curtail=False)
    skipped = next(e for e in events if isinstance(e, Skipped))
    assert asked == [(skipped.segment, skipped.formulation)] * 2
    at = events.index(skipped)
    assert skipped.trials == sum(isinstance(e, TrialFinished) for e in events[:at])
    assert {e.purpose for e in events[at:] if isinstance(e, TrialFinished)} == {"evaluate"}
    assert (learned.success.successes, learned.success.trials) == (successes, 20)
    assert not learned.accepted
    assert not events[-1].accepted


def test_what_was_judged_before_it_is_skipped_is_not_judged_again(learn):
    number = count()
    events, learned = learn(lambda _: 0.2 * (next(number) % 8 == 7), skip=lambda *_: True)
    kinds = [type(e) for e in events]
    at = kinds.index(Skipped)
    assert Evaluated in kinds[:at]  # it succeeds too seldom to be accepted at once
    assert kinds[at:] == [Skipped, Evaluated]
    assert 0.8 <= learned.success.rate < 0.95
    assert not learned.accepted


@pytest.mark.parametrize(
    ("judgements", "kept"),
    [
        ([(False, 0.9, 0.95), (True, 0.1, 0.8)], 1),  # accepted before firm and often
        ([(True, 0.3, 0.95), (True, 0.6, 0.85)], 1),  # firm before often
        ([(True, 0.6, 0.85), (True, 0.3, 0.95)], 0),
        ([(True, 0.6, 0.85), (True, 0.6, 0.9)], 1),
        ([(True, 0.6, 0.9), (True, 0.6, 0.9)], 0),  # of equals, the first
        ([(False, 0.0, 0.4), (False, 0.0, 0.5), (False, 0.0, 0.3)], 1),
    ],
)
def test_the_best_that_was_judged_has_the_last_word(learn, monkeypatch, judgements, kept):
    rows, judge = [], runs.Runs.judge

    def scripted(self, row, *args, **how):
        learned = yield from judge(self, row, *args, **how)
        rows.append(row)
        accepted, firm, rate = judgements[min(len(rows), len(judgements)) - 1]
        return replace(learned, accepted=accepted, firm=firm, success=Success(round(100 * rate), 100))

    monkeypatch.setattr(runs.Runs, "judge", scripted)
    learned = learn(lambda _: 0.0, converged_below=0.0, updates=len(judgements) - 1, more_updates=0)[1]
    assert len(rows) == len(judgements) + 1
    assert rows[-1] is rows[kept]
    assert learned.row is rows[kept]


def test_a_trial_competes_once(learn):
    events, _ = learn(failing(0))
    competing = Counter(id(e.policies[-1]) for e in events if getattr(e, "purpose", "") == "choose")
    assert len(competing) > 5
    assert set(competing.values()) == {load_settings().learning.candidate_starts}


def test_until_a_trial_succeeds_only_the_end_may_count(learn):
    def means(by):
        events, _ = learn(held_from(1e6), improve_by=by)
        return [e.policy.gripper_weights for e in events if isinstance(e, PolicyUpdated)]

    first, terminal, total = map(means, ("terminal-first", "terminal", "total"))
    assert all(np.array_equal(a, b) for a, b in zip(first, terminal, strict=True))
    assert not np.array_equal(first[0], total[0])
