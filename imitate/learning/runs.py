"""The trials of one formulation: run, numbered, and judged."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imitate.events import Evaluated, Event, Purpose, TrialFinished
from imitate.geometry import Array
from imitate.learning.bodies import unseen
from imitate.learning.grasp import fell
from imitate.learning.option import Success
from imitate.learning.problem import Problem, cost_of, failure_of, misses_of
from imitate.learning.starts import perturbed_starts
from imitate.learning.trials import WATCHING, Task, Trials
from imitate.learning.verdict import displaced
from imitate.record import Start, TrialRecord
from imitate.settings import Settings
from imitate.skill import CostTerms, Miss, Policy
from imitate.world.trial import Outcome

Row = tuple[Policy, ...]
"""Policies on trial in a row: its own is the last; of the one before it only the goal is learned."""


@dataclass(frozen=True)
class Learned:
    """What became of a formulation.

    Attributes:
        row: the best found, accepted or not.
        cost: its mean total from the perturbed starts.
        success: over the perturbed starts.
        fair: share of successes, of those starts where what earlier skills placed was right when this began.
        firm: share of them that succeeded with a margin.
        accepted: P ≥ α.
        stopped: why not all of the starts were tried, in words; empty when they were.
    """

    row: Row
    cost: float
    success: Success
    fair: float
    firm: float
    accepted: bool
    stopped: str = ""

    @property
    def policy(self) -> Policy:
        """The formulation's own."""
        return self.row[-1]


_JUDGING, _AFRESH = 2, 3
"""keys of the starts by which a row is judged."""


class Runs:
    """Runs a formulation's trials, each with its number's chance, and says what came of them.

    Attributes:
        update: how many updates the policies on trial have had.
    """

    def __init__(
        self, problem: Problem, prefix: tuple[Policy, ...], trials: Trials, seed: np.random.SeedSequence
    ) -> None:
        self.problem = problem
        self.settings: Settings = trials.settings
        self.update = 0
        self._prefix = prefix
        self._trials = trials
        self._entropy = seed
        self._expected: Array | None = None  # where exploration last saw the objects, if trials are watched
        self._count = 0

    @property
    def count(self) -> int:
        """How many trials have been run."""
        return self._count

    def skip(self) -> bool:
        """Whether the operator gives the formulation up here."""
        return self._trials.skip(*self.id)

    @property
    def id(self) -> tuple[int, int]:
        """Segment and formulation."""
        f = self.problem.formulation
        return f.segment, f.index

    def seed(self, *key: int) -> np.random.SeedSequence:
        """Of what chance there is in this formulation, by what it is for."""
        return np.random.SeedSequence(self._entropy.entropy, spawn_key=(*self.id, *key))

    def prepare(self, shown: Start) -> Generator[Event, None, Start]:
        """Where exploration starts: where the accepted options end from the shown start, at rest."""
        if not self._prefix:
            return shown
        outcome = next(self._trials.run(self._tasks([(shown, self._prefix)])))
        yield self._event(outcome, "prepare", self._prefix)
        record, seen = outcome.record, outcome.seen
        self._expected = None if seen is None else seen.believed[-1]
        return Start(record.joint_positions[-1], record.object_poses[-1], float(record.commands[-1, -1]))

    def explore(self, start: Start, batch: Sequence[Row]) -> Generator[Event, None, list[TrialFinished]]:
        """A trial of each row from one start."""
        tasks = self._tasks([(start, row) for row in batch], self._expected)
        done = []
        for row, outcome in zip(batch, self._trials.run(tasks), strict=True):
            done.append(self._event(outcome, "explore", row))
            yield done[-1]
        return done

    def choose(
        self, rows: Sequence[Row], starts: Sequence[Start]
    ) -> Generator[Event, None, list[list[TrialFinished]]]:
        """A trial of each row from each start, the accepted options before it; each row's trials."""
        asked = [(start, (*self._prefix, *row)) for row in rows for start in starts]
        events = []
        for (_, policies), outcome in zip(asked, self._trials.run(self._tasks(asked)), strict=True):
            events.append(self._event(outcome, "choose", policies))
            yield events[-1]
        return [events[k : k + len(starts)] for k in range(0, len(events), len(starts))]

    def judge(self, row: Row, afresh: bool = False, last: bool = False) -> Generator[Event, None, Learned]:
        """P over the perturbed starts, and what the row cost there.

        Args:
            row: what is judged.
            afresh: on other starts than those by which others have been judged and it was chosen.
            last: nothing but α is asked for any more.
        """
        s = self.settings.learning
        chance = self.seed(_AFRESH if afresh else _JUDGING)
        starts = perturbed_starts(self._trials.spec, s.evaluation_starts, chance, self.settings)
        policies, events, stopped = (*self._prefix, *row), list[TrialFinished](), ""
        for outcome in self._trials.run(self._tasks([(start, policies) for start in starts])):
            events.append(self._event(outcome, "evaluate", policies))
            yield events[-1]
            left = len(starts) - len(events)
            if s.curtail and left and (stopped := self._settled(events, left, last)):
                break
        success = Success(sum(event.success for event in events), len(events))
        cost = float(np.mean([event.cost.total for event in events]))
        fair = self._fair(events)
        share = sum(event.success for event in fair) / max(len(fair), 1)
        accepted = success.rate >= s.alpha
        return Learned(row, cost, success, share, self.firm(fair), accepted, stopped)

    def _settled(self, events: Sequence[TrialFinished], left: int, last: bool) -> str:
        # Why nothing that the trials left may come to changes what is decided by them all; empty: it may.
        s = self.settings.learning
        starts = len(events) + left
        successes = sum(event.success for event in events)
        if Success(successes + left, starts).rate < s.alpha:
            return "α is out of reach"
        if Success(successes, starts).rate < s.alpha:
            return ""
        if last:
            return "α is reached"
        if len(events) < s.sure * starts:
            return ""
        fair = self._fair(events)
        at_worst = len(fair) / (len(fair) + left)
        share = sum(event.success for event in fair) / max(len(fair), 1)
        sure = share * at_worst >= s.safe and self.firm(fair) * at_worst >= s.sure
        return "α is reached for sure" if sure else ""

    def evaluated(self, learned: Learned) -> Evaluated:
        """What was learned, as an event."""
        p = learned.success
        return Evaluated(
            *self.id, p.successes, p.trials, *p.interval, learned.accepted, learned.cost, learned.stopped
        )

    def firm(self, events: Sequence[TrialFinished]) -> float:
        """The share of trials that succeeded with a margin, so that a start a little different will too.

        What is carried was put down, too, and did not fall to its place. How near its margin an object is
        that an earlier skill placed, this one cannot change.
        """
        s = self.settings.learning
        near, angle = s.margin * s.near, s.margin * s.near_angle
        strict = s.model_copy(update={"near": near, "near_angle": angle})
        own = replace(self.problem, placed=())
        firm = [
            not misses_of(own, e.believed, "", e.cost, strict) and not self._dropped(e.believed)
            for e in events
            if e.success and e.believed is not None
        ]
        return sum(firm) / max(len(events), 1)

    def _dropped(self, record: TrialRecord) -> bool:
        names, abstraction = self.problem.object_names, self.problem.formulation.abstraction
        s = self.settings.learning
        return any(fell(record, names, body, abstraction.reference, s) for body in abstraction.carried)

    def _fair(self, events: Sequence[TrialFinished]) -> list[TrialFinished]:
        # What was off its place before this skill began, none of its policies can mend.
        names, placed = self.problem.object_names, self.problem.placed
        seen = ((e, e.believed) for e in events)
        return [e for e, record in seen if record is None or not displaced(placed, record, names)]

    def _event(self, outcome: Outcome, purpose: Purpose, policies: tuple[Policy, ...]) -> TrialFinished:
        s = self.settings.learning
        stopped = outcome.unreachable or outcome.unseen
        if purpose == "prepare":
            cost, lost = CostTerms(0.0, 0.0, 0.0), outcome.unseen
            misses: tuple[Miss, ...] = (Miss("reach", stopped),) if stopped else ()
        else:
            lost = outcome.unseen or unseen(outcome.seen, self.problem.object_names, self.problem.judged)
            cost = cost_of(self.problem, outcome.believed, bool(stopped), s)
            misses = misses_of(self.problem, outcome.believed, outcome.unreachable, cost, s)
        if lost and not outcome.unreachable:
            misses = (Miss("sight", lost),)
        trial, self._count = self._count, self._count + 1
        failure = failure_of(misses)
        return TrialFinished(
            *self.id,
            trial,
            purpose,
            self.update,
            policies,
            cost,
            not misses,
            failure,
            outcome.record,
            misses,
            outcome.seen,
        )

    def _tasks(
        self, trials: Sequence[tuple[Start, tuple[Policy, ...]]], expected: Array | None = None
    ) -> list[Task]:
        # What chance there is in watching a trial follows from its number.
        return [
            Task(start, policies, self.seed(WATCHING, self._count + k), expected)
            for k, (start, policies) in enumerate(trials)
        ]
