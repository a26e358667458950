"""How far a session is: its events folded into skills, formulations and trials. Knows no view.

The command line's table, its JSON and the terminal application are all read off the same `Progress`.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from imitate import events
from imitate.events import Event, Purpose
from imitate.settings import Settings, settings_from_toml
from imitate.skill import CostTerms, Decision, Formulation, Segment


@dataclass(frozen=True)
class Trial:
    """A `TrialFinished` without its policies and steps, so that thousands are cheap to keep."""

    number: int
    purpose: Purpose
    update: int
    cost: CostTerms
    success: bool
    failure: str


@dataclass(frozen=True)
class Update:
    """A `PolicyUpdated` without its policy; ``after`` is how many trials had run."""

    number: int
    after: int
    cost: float


@dataclass
class Attempt:
    """One formulation of a skill, and what came of it."""

    formulation: Formulation
    trials: list[Trial] = field(default_factory=list)
    updates: list[Update] = field(default_factory=list)
    converged: str = ""
    evaluated: events.Evaluated | None = None
    given_up: str = ""
    evidence: events.Evidence | None = None
    learned: events.OptionLearned | None = None

    @property
    def accepted(self) -> bool:
        """Whether P(β=1|π) reached α."""
        return bool(self.learned or (self.evaluated and self.evaluated.accepted))

    @property
    def explored(self) -> int:
        """Trials that count towards the budget."""
        return sum(trial.purpose == "explore" for trial in self.trials)

    @property
    def cost(self) -> float | None:
        """Cost of the policy that was judged; before that, of the best exploring trial; None without."""
        if self.evaluated:
            return self.evaluated.cost
        return min((trial.cost.total for trial in self.trials if trial.purpose == "explore"), default=None)


@dataclass
class Skill:
    """A segment of the demonstration and every formulation tried for it, in order."""

    index: int
    segment: Segment
    attempts: list[Attempt] = field(default_factory=list)

    @property
    def accepted(self) -> bool:
        """Whether the latest formulation was accepted (going back to a segment opens it again)."""
        return bool(self.attempts) and self.attempts[-1].accepted


@dataclass
class Progress:
    """Everything that the events so far say; `fold` them in order."""

    started: events.SessionStarted | None = None
    segmented: events.Segmented | None = None
    decisions: list[Decision] = field(default_factory=list)
    skills: list[Skill] = field(default_factory=list)
    present: Attempt | None = None
    reproduction: list[Trial] = field(default_factory=list)
    reproduced: events.Reproduced | None = None
    finished: events.SessionFinished | None = None
    counts: Counter[Purpose] = field(default_factory=Counter)

    @cached_property
    def settings(self) -> Settings:
        """The session's settings; the defaults until it has started."""
        return settings_from_toml(self.started.settings) if self.started else Settings()

    def attempt(self, segment: int, formulation: int) -> Attempt:
        """The formulation with that index of that segment."""
        by_index = {attempt.formulation.index: attempt for attempt in self.skills[segment].attempts}
        return by_index[formulation]

    def fold(self, event: Event) -> None:
        """Take one event in."""
        match event:
            case events.SessionStarted():
                self.started = event
                self.__dict__.pop("settings", None)
            case events.Segmented(segments=segments):
                self.segmented = event
                self.skills = [Skill(i, segment) for i, segment in enumerate(segments)]
            case events.Decided(decision=decision, segments=segments):
                self.decisions.append(decision)
                self.skills = [Skill(i, segment) for i, segment in enumerate(segments)]
            case events.FormulationStarted(formulation=formulation):
                self.present = Attempt(formulation)
                self.skills[formulation.segment].attempts.append(self.present)
            case events.TrialFinished():
                self._fold_trial(event)
            case events.Reproduced():
                self.reproduced = event
            case events.SessionFinished():
                self.finished = event
            case _:
                self._fold_attempt(event)

    def _fold_trial(self, event: events.TrialFinished) -> None:
        trial = Trial(event.trial, event.purpose, event.update, event.cost, event.success, event.failure)
        self.counts[event.purpose] += 1
        if event.purpose == "reproduce":
            self.reproduction.append(trial)
        else:
            self.attempt(event.segment, event.formulation).trials.append(trial)

    def _fold_attempt(
        self,
        event: events.PolicyUpdated
        | events.Converged
        | events.Skipped
        | events.Evaluated
        | events.Reformulated
        | events.OptionLearned,
    ) -> None:
        attempt = self.attempt(event.segment, event.formulation)
        match event:
            case events.PolicyUpdated(update=number, cost=cost):
                attempt.updates.append(Update(number, len(attempt.trials), cost))
            case events.Converged(reason=reason):
                attempt.converged = reason
            case events.Skipped():
                attempt.converged = "the operator skipped it"
            case events.Evaluated():
                attempt.evaluated = event
            case events.Reformulated(reason=reason):
                attempt.given_up, attempt.evidence = reason, event.evidence
            case events.OptionLearned():
                attempt.learned = event


def learn_report(progress: Progress, session: Path | str, wall_s: float) -> dict[str, Any]:
    """What ``imitate learn --json`` prints; ``wall_s`` is how long it took, in seconds.

    A formulation that was never judged reports 0 of 0 with the interval that says nothing, [0, 1].
    """
    return {
        "session": str(session),
        "seed": progress.started.seed if progress.started else None,
        "segments": [
            {"index": skill.index, "formulations": [_formulation_report(a) for a in skill.attempts]}
            for skill in progress.skills
        ],
        "reproduced": bool(progress.finished and progress.finished.reproduced),
        "wall_s": wall_s,
    }


def _formulation_report(attempt: Attempt) -> dict[str, Any]:
    judged = attempt.evaluated
    return {
        "relevant": list(attempt.formulation.abstraction.relevant),
        "reference": attempt.formulation.abstraction.reference,
        "actions": list(attempt.formulation.actions),
        "trials": attempt.explored,
        "updates": len(attempt.updates),
        "cost": attempt.cost,
        "success": {
            "successes": judged.successes if judged else 0,
            "trials": judged.trials if judged else 0,
            "low": judged.low if judged else 0.0,
            "high": judged.high if judged else 1.0,
            "stopped": judged.stopped if judged else "",
        },
        "accepted": attempt.accepted,
        "failed_of": _failed_of(attempt.evidence),
        "initiation": _initiation_report(attempt.learned),
    }


def _failed_of(evidence: events.Evidence | None) -> list[dict[str, Any]]:
    keys = ("body", "term", "grasp", "starts", "distance", "angle")
    return [{key: getattr(s, key) for key in keys} for s in evidence.shortfalls] if evidence else []


def _initiation_report(learned: events.OptionLearned | None) -> dict[str, Any] | None:
    if learned is None or learned.initiation is None:
        return None
    initiation = learned.initiation
    return {
        "trials": len(initiation.succeeded),
        "failures": initiation.failures,
        "precision": list(initiation.precision),
        "recall": list(initiation.recall),
        "ends": learned.ends,
        "ends_inside": learned.ends_inside,
    }
