"""The whole task from perturbed starts, judged by where the objects end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import Demonstration
from imitate.events import Event, Reproduced, TrialFinished
from imitate.learning.grasp import grasp_of
from imitate.learning.initiation import probability, start_of
from imitate.learning.option import Option, Success
from imitate.learning.placement import Placement, misplaced, placements
from imitate.learning.problem import cost_of, failure_of
from imitate.learning.trials import Task, Trials, perturbed_starts
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
    """Runs the options in a row from ``count`` perturbed starts; done when at least α of them succeed."""
    wanted = placements(demonstration, segments)
    policies = tuple(option.policy for option in options)
    starts = perturbed_starts(trials.spec, count, seed, trials.settings)
    judge = _Judge(options, wanted, trials.settings.learning)
    successes = outside = outside_failed = 0
    for number, outcome in enumerate(trials.run([Task(start, policies) for start in starts])):
        strange = judge.began_outside(outcome.record)
        event = judge.event(number, outcome, strange)
        successes += event.success
        outside += bool(strange)
        outside_failed += bool(strange) and not event.success
        yield event
    success = Success(successes, count)
    reproduced = success.rate >= trials.settings.learning.alpha
    yield Reproduced(successes, count, *success.interval, reproduced, outside, outside_failed)


@dataclass(frozen=True)
class _Judge:
    options: tuple[Option, ...]
    wanted: tuple[Placement, ...]
    settings: Learning

    def event(self, number: int, outcome: Outcome, strange: str) -> TrialFinished:
        problem, record = self.options[-1].problem, outcome.record
        misses = self._misses(outcome)
        failure = "; ".join(filter(None, (failure_of(misses), strange)))
        return TrialFinished(
            segment=problem.formulation.segment,
            formulation=problem.formulation.index,
            trial=number,
            purpose="reproduce",
            update=0,
            policies=tuple(option.policy for option in self.options),
            cost=cost_of(problem, record, bool(outcome.unreachable), self.settings),
            success=not misses,
            failure=failure if misses else "",
            record=record,
            misses=misses,
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

    def _misses(self, outcome: Outcome) -> tuple[Miss, ...]:
        if outcome.unreachable:
            return (Miss("reach", outcome.unreachable),)
        record, names = outcome.record, self.options[-1].problem.object_names
        return tuple(
            Miss("place", words, place.name, grasp=self._grasp(record, place))
            for place in self.wanted
            if (words := misplaced(record, names, (place,), self.settings))
        )

    def _grasp(self, record: TrialRecord, place: Placement) -> Grasp | None:
        # Of the option that was the last to carry the object.
        for i in reversed(range(len(record.option_starts))):
            if place.name in self.options[i].problem.formulation.abstraction.carried:
                return grasp_of(record, place.index, i)
        return None
