"""The whole task from perturbed starts, judged by where the objects end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import Demonstration
from imitate.events import Event, Reproduced, TrialFinished
from imitate.geometry import Array, relative
from imitate.learning.option import Option, Success
from imitate.learning.problem import cost_of, resting
from imitate.learning.trials import Task, Trials, perturbed_starts
from imitate.record import TrialRecord
from imitate.settings import Learning
from imitate.skill import Policy, Segment
from imitate.world.trial import Outcome


@dataclass(frozen=True)
class Placement:
    """Where an object is to end.

    Attributes:
        index, name: the object.
        reference_index, reference: the object in whose frame it was last carried.
        position: (3,) shown there at the demonstration's end.
        left: whether the hand has left it by then.
    """

    index: int
    name: str
    reference_index: int
    reference: str
    position: Array
    left: bool


def placements(demonstration: Demonstration, segments: tuple[Segment, ...]) -> tuple[Placement, ...]:
    """Where each carried object is shown to end, relative to its reference object."""
    names = demonstration.object_names
    last: dict[str, tuple[int, str]] = {}
    for i, segment in enumerate(segments):
        for name in segment.abstraction.carried:
            last[name] = (i, segment.abstraction.reference)
    found = []
    for name, (i, reference) in last.items():
        pose = relative(demonstration.pose_of(reference)[-1], demonstration.pose_of(name)[-1])
        left = any(name not in later.abstraction.carried for later in segments[i + 1 :])
        found.append(Placement(names.index(name), name, names.index(reference), reference, pose[:3], left))
    return tuple(found)


def misplaced(record: TrialRecord, wanted: tuple[Placement, ...], settings: Learning) -> str:
    """What is not where it was shown at a trial's end, in words; empty when everything is."""
    reasons = []
    for place in wanted:
        now = relative(record.object_poses[-1, place.reference_index], record.object_poses[-1, place.index])
        off = float(np.linalg.norm(now[:3] - place.position))
        if off > settings.near:
            reasons.append(
                f"{place.name} ends {off * 1e3:.0f} mm from its place relative to {place.reference}"
            )
        elif not resting(record.object_poses[:, place.index], record.time_step, settings):
            reasons.append(f"{place.name} is still moving")
        elif place.left and record.contact_forces[-1, place.index] > 0:
            reasons.append(f"the gripper still touches {place.name}")
    return "; ".join(reasons)


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
        failure = outcome.unreachable or misplaced(record, self.wanted, self.settings)
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
