"""The whole task from perturbed starts, judged by what the demonstration did with the objects."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from imitate.demonstration import Demonstration
from imitate.events import Event, Reproduced, TrialFinished
from imitate.learning.bodies import unseen
from imitate.learning.grasp import grasp_of
from imitate.learning.initiation import probability, start_of
from imitate.learning.option import Option, Success
from imitate.learning.places import Place, asked_for, places
from imitate.learning.problem import cost_of, failure_of
from imitate.learning.starts import perturbed_starts
from imitate.learning.trials import WATCHING, Task, Trials
from imitate.learning.verdict import verdict
from imitate.record import TrialRecord
from imitate.settings import Learning
from imitate.skill import Grasp, Miss, Segment
from imitate.world.trial import Outcome


def reproduce(
    demonstration: Demonstration,
    segments: tuple[Segment, ...],
    options: tuple[Option, ...],
    trials: Trials,
    seed: np.random.SeedSequence,
    count: int,
) -> Iterator[Event]:
    """Runs the options in a row from ``count`` perturbed starts; done when at least α of them succeed.

    Args:
        demonstration: every pose known.
        segments: as found, or as the operator decided; how their problems were stated judges nothing.
        options: one for each segment.
        trials: run them.
        seed: of the starts.
        count: how many.
    """
    wanted = places(demonstration, segments, trials.settings.learning)
    policies = tuple(option.policy for option in options)
    starts = perturbed_starts(trials.spec, count, seed, trials.settings)
    judge = _Judge(options, wanted, trials.settings.learning)
    tasks = [Task(start, policies, _watching(seed, k)) for k, start in enumerate(starts)]
    successes = outside = outside_failed = really = 0
    for number, outcome in enumerate(trials.run(tasks)):
        strange = judge.began_outside(outcome.believed)
        event = judge.event(number, outcome, strange)
        successes += event.success
        outside += bool(strange)
        outside_failed += bool(strange) and not event.success
        really += not judge.misses(replace(outcome, seen=None))
        yield event
    success, s = Success(successes, count), trials.settings.learning
    truth = really if s.observe_trials else None
    reproduced = success.rate >= s.alpha
    yield Reproduced(successes, count, *success.interval, reproduced, outside, outside_failed, truth)


def _watching(seed: np.random.SeedSequence, number: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, WATCHING, number))


@dataclass(frozen=True)
class _Judge:
    options: tuple[Option, ...]
    wanted: tuple[Place, ...]
    settings: Learning

    def event(self, number: int, outcome: Outcome, strange: str) -> TrialFinished:
        problem, stopped = self.options[-1].problem, bool(outcome.unreachable or outcome.unseen)
        misses = self.misses(outcome)
        failure = "; ".join(filter(None, (failure_of(misses), strange)))
        return TrialFinished(
            segment=problem.formulation.segment,
            formulation=problem.formulation.index,
            trial=number,
            purpose="reproduce",
            update=0,
            policies=tuple(option.policy for option in self.options),
            cost=cost_of(problem, outcome.believed, stopped, self.settings),
            success=not misses,
            failure=failure if misses else "",
            record=outcome.record,
            misses=misses,
            seen=outcome.seen,
        )

    def began_outside(self, record: TrialRecord) -> str:
        """The first option that began outside its initiation set, in words; empty where none did."""
        for i in range(len(record.option_starts)):
            initiation, problem = self.options[i].initiation, self.options[i].problem
            if initiation is None:
                continue
            start = start_of(record, problem.object_names, problem.formulation.abstraction, i)
            if (p := probability(initiation, start)) < initiation.threshold:
                return f"skill {i + 1} began outside its initiation set (p = {p:.2f})"
        return ""

    def misses(self, outcome: Outcome) -> tuple[Miss, ...]:
        """What of the task is not done; empty when everything is where it was shown."""
        if outcome.unreachable:
            return (Miss("reach", outcome.unreachable),)
        record, names = outcome.believed, self.options[-1].problem.object_names
        if lost := outcome.unseen or unseen(outcome.seen, names, asked_for(self.wanted)):
            return (Miss("sight", lost),)
        missed = verdict(self.wanted, record, names, self.settings)
        return tuple(replace(miss, grasp=self._grasp(record, names.index(miss.body))) for miss in missed)

    def _grasp(self, record: TrialRecord, index: int) -> Grasp | None:
        # Of the option that was the last to carry the object.
        for i in reversed(range(len(record.option_starts))):
            problem = self.options[i].problem
            if problem.object_names[index] in problem.formulation.abstraction.carried:
                return grasp_of(record, index, i)
        return None
