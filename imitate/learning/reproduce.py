"""The whole task from perturbed starts, judged by where the objects end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import Demonstration
from imitate.events import Event, Reproduced, TrialFinished
from imitate.learning.option import Option, Success
from imitate.learning.placement import Placement, misplaced, placements
from imitate.learning.problem import cost_of
from imitate.learning.trials import Task, Trials, perturbed_starts
from imitate.settings import Learning
from imitate.skill import Policy, Segment
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
    judge = _Judge(options[-1], policies, wanted, trials.settings.learning)
    successes = 0
    for number, outcome in enumerate(trials.run([Task(start, policies) for start in starts])):
        event = judge.event(number, outcome)
        successes += event.success
        yield event
    success = Success(successes, count)
    yield Reproduced(successes, count, *success.interval, success.rate >= trials.settings.learning.alpha)


@dataclass(frozen=True)
class _Judge:
    last: Option
    policies: tuple[Policy, ...]
    wanted: tuple[Placement, ...]
    settings: Learning

    def event(self, number: int, outcome: Outcome) -> TrialFinished:
        problem, record = self.last.problem, outcome.record
        failure = outcome.unreachable or misplaced(record, problem.object_names, self.wanted, self.settings)
        return TrialFinished(
            segment=problem.formulation.segment,
            formulation=problem.formulation.index,
            trial=number,
            purpose="reproduce",
            update=0,
            policies=self.policies,
            cost=cost_of(problem, record, bool(outcome.unreachable), self.settings),
            success=not failure,
            failure=failure,
            record=record,
        )
