"""The whole task in a made-up world: what is said where it fails."""

from dataclasses import replace

import numpy as np
import pytest
from records import done, moved

from imitate.events import Reproduced, TrialFinished
from imitate.learning.initiation import initiation_set, start_of
from imitate.learning.option import Option
from imitate.learning.problem import formulate
from imitate.learning.reproduce import reproduce
from imitate.settings import Settings
from imitate.skill import Formulation
from imitate.world.scene import scene_of
from imitate.world.trial import Outcome

SETTINGS = Settings()


class Pretended:
    """Trials that come out as these records say."""

    def __init__(self, demonstration, outcomes):
        self.spec = scene_of(demonstration, SETTINGS.world)
        self.settings = SETTINGS
        self.outcomes = outcomes

    def run(self, tasks):
        yield from self.outcomes[: len(tasks)]


def chained(demonstration):
    """A carry of 1 s, held all along, and a retreat of 1 s; everything at rest in its place."""
    record = replace(done(demonstration), option_starts=(0, 240))
    commands, forces = record.commands.copy(), record.contact_forces.copy()
    commands[:60, -1] = 20.0
    forces[:240, 0] = 40.0
    return replace(record, commands=commands, contact_forces=forces)


@pytest.fixture
def options(stacking):
    """Carry and retreat, each tried five times from where the demonstration ends."""
    demonstration, segments = stacking
    record, made = chained(demonstration), []
    for i, segment in enumerate(segments):
        problem = formulate(
            demonstration, segments, Formulation(i, 0, segment.abstraction, ("pose",), ""), SETTINGS
        )
        start = start_of(record, demonstration.object_names, segment.abstraction, i)
        tried = initiation_set(
            segment.abstraction, np.repeat(start[None], 5, axis=0), np.ones(5), SETTINGS.learning
        )
        made.append(Option(problem, problem.imitated, tried))
    return tuple(made)


@pytest.fixture
def run(stacking, options):
    demonstration, segments = stacking

    def course(*outcomes, options=options):
        trials = Pretended(demonstration, outcomes)
        *tried, result = reproduce(
            demonstration, segments, options, trials, np.random.SeedSequence(0), len(outcomes)
        )
        assert all(isinstance(event, TrialFinished) for event in tried)
        assert isinstance(result, Reproduced)
        return tried, result

    return course


def test_a_task_that_ends_as_shown_is_reproduced(run, stacking):
    (trial,), result = run(Outcome(chained(stacking[0])))
    assert (trial.success, trial.failure, trial.misses) == (True, "", ())
    assert (result.successes, result.trials, result.outside, result.outside_failed) == (1, 1, 0, 0)


def test_a_misplaced_object_is_told_with_its_grasp_and_where_a_skill_began_outside(run, stacking):
    record = chained(stacking[0])
    later = record.object_poses.copy()
    later[200:, 0, 0] += 0.1
    forces = record.contact_forces.copy()
    forces[120:, 0] = 0
    dropped = replace(record, object_poses=later, contact_forces=forces)
    (good, bad), result = run(Outcome(record), Outcome(dropped))
    assert good.success
    assert bad.failure == (
        "cubeA ends 100 mm from its place relative to cubeB; cubeA slipped from the grip at 0.5 s of 1.0, "
        "0 mm up; "
        "skill 2 began outside its initiation set (p = 0.00)"
    )
    (miss,) = bad.misses
    assert (miss.term, miss.body, miss.grasp.kind) == ("place", "cubeA", "slipped")
    assert (result.successes, result.outside, result.outside_failed) == (1, 1, 1)


def test_beginning_outside_alone_is_no_failure_but_is_counted(run, stacking):
    record = chained(stacking[0])
    hand = record.hand_poses.copy()
    hand[:, 2] += 0.1
    (trial,), result = run(Outcome(replace(record, hand_poses=hand)))
    assert (trial.success, trial.failure) == (True, "")
    assert (result.outside, result.outside_failed) == (1, 0)


def test_a_chain_that_stops_early_is_judged_by_the_options_that_began(run, stacking):
    stopped = replace(moved(chained(stacking[0]), 0, [0.1, 0, 0]), option_starts=(0,))
    (trial,), _ = run(Outcome(stopped, "out of reach 0.1 s into the skill"))
    assert trial.failure.startswith("out of reach 0.1 s into the skill; skill 1 began outside")
    assert [miss.term for miss in trial.misses] == ["reach"]


def test_options_of_sessions_without_initiation_sets_are_never_outside(run, stacking, options):
    old = tuple(replace(option, initiation=None) for option in options)
    far = moved(chained(stacking[0]), 0, [0.1, 0, 0])
    (trial,), result = run(Outcome(far), options=old)
    assert "initiation" not in trial.failure
    assert result.outside == 0
