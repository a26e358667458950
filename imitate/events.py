"""What can happen in a session: frozen, picklable; says nothing of who listens.

The order of a session: SessionStarted, Segmented, Decided*, then for each segment and each of its
formulations FormulationStarted, (TrialFinished, PolicyUpdated)*, Converged or Skipped or neither,
TrialFinished (evaluations), Evaluated, and then either OptionLearned or Reformulated; at the end
TrialFinished (reproduction), Reproduced, SessionFinished.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from imitate.demonstration import Demonstration
from imitate.record import SceneSpec, Sightings, TrialRecord, as_seen
from imitate.skill import CostTerms, Decision, Formulation, InitiationSet, Miss, Policy, Segment, Term

Purpose = Literal["prepare", "explore", "choose", "evaluate", "reproduce"]


@dataclass(frozen=True)
class SessionStarted:
    """Everything that the session follows from.

    Attributes:
        source: name of the file that was given.
        source_hash: its SHA-256, hexadecimal.
        settings: all settings, resolved, as TOML.
        versions: package → version, and "platform".
    """

    source: str
    source_hash: str
    seed: int
    settings: str
    versions: Mapping[str, str]
    demonstration: Demonstration
    scene: SceneSpec


@dataclass(frozen=True)
class Segmented:
    """The segments as found, before the operator's decisions."""

    mode: str
    segments: tuple[Segment, ...]


@dataclass(frozen=True)
class Decided:
    """The operator overruled something; ``segments`` are those that result."""

    decision: Decision
    segments: tuple[Segment, ...]


@dataclass(frozen=True)
class FormulationStarted:
    """A problem was stated and will be learned."""

    formulation: Formulation


@dataclass(frozen=True)
class TrialFinished:
    """One trial ran in physics.

    Attributes:
        segment, formulation: indices.
        trial: counts every trial of the formulation, whatever its purpose.
        purpose: prepare (brings the scene to where the skill starts; none of its policies is on trial),
            explore (counts towards the trial budget), choose (between candidate policies), evaluate
            (towards P), reproduce (the whole task).
        update: how many updates the policy had had.
        policies: those run, one for each option in the row; the last is the one on trial.
        success: whether β held at its end.
        failure: why not, in words; empty on success.
        record: every step, or None when the session was asked to keep none.
        misses: the same reasons as data; none in sessions of before they were kept.
        seen: where the camera saw the objects; None: cost and success are from the physics.
    """

    segment: int
    formulation: int
    trial: int
    purpose: Purpose
    update: int
    policies: tuple[Policy, ...]
    cost: CostTerms
    success: bool
    failure: str
    record: TrialRecord | None
    misses: tuple[Miss, ...] = ()
    seen: Sightings | None = None

    @property
    def believed(self) -> TrialRecord | None:
        """The record as the learner knows it: objects where they were seen last, if they were watched."""
        return None if self.record is None else as_seen(self.record, self.seen)


@dataclass(frozen=True)
class PolicyUpdated:
    """PI² made a new mean policy from the trials so far; ``cost`` is that of the best trial used."""

    segment: int
    formulation: int
    update: int
    policy: Policy
    cost: float


@dataclass(frozen=True)
class Converged:
    """Improvement stopped, and why, in words."""

    segment: int
    formulation: int
    update: int
    reason: str


@dataclass(frozen=True)
class Skipped:
    """The operator gives up a formulation after so many of its trials: it is not accepted, whatever its P."""

    segment: int
    formulation: int
    trials: int


@dataclass(frozen=True)
class Evaluated:
    """P(β = 1 | π) from perturbed starts, with its Wilson interval at 95 %.

    The last one of a formulation decides; ``cost`` is the policy's mean total over the starts. ``stopped``
    says why not all of the starts were tried, empty where they were.
    """

    segment: int
    formulation: int
    successes: int
    trials: int
    low: float
    high: float
    accepted: bool
    cost: float
    stopped: str = ""


@dataclass(frozen=True)
class Shortfall:
    """What some of the starts failed of, counted over those by which P was estimated.

    Attributes:
        body, term: as in `imitate.skill.Miss`.
        grasp: how the body was grasped, a `Gripping`; empty where it is not one that is carried.
        starts: how many failed of this; one start may fail of several things.
        distance: m from the shown position, the median.
        angle: rad from the shown orientation, the median.
        words: of one of them.
    """

    body: str
    term: Term
    grasp: str
    starts: int
    distance: float
    angle: float
    words: str


@dataclass(frozen=True)
class Evidence:
    """What a formulation came to.

    Attributes:
        successes, trials, low, high: P of the best policy, with Wilson's interval at 95 %.
        explored: trials spent on learning.
        best_costs, mean_costs: total cost of those trials, before the first update and then after each.
        shortfalls: what the best policy failed of, the most frequent first.
        policy: the best one found.
        stopped: why P was not estimated over all of the starts, empty where it was.
    """

    successes: int
    trials: int
    low: float
    high: float
    explored: int
    best_costs: tuple[float, ...]
    mean_costs: tuple[float, ...]
    shortfalls: tuple[Shortfall, ...]
    policy: Policy
    stopped: str = ""


@dataclass(frozen=True)
class Reformulated:
    """A formulation was given up; ``reason`` says what failed and what is changed, for the operator.

    Sessions of before the evidence was kept have none.
    """

    segment: int
    formulation: int
    reason: str
    evidence: Evidence | None = None


@dataclass(frozen=True)
class OptionLearned:
    """An option ⟨I, π, β⟩ was accepted for a segment.

    Attributes:
        segment, formulation: indices; they say β.
        policy: π.
        initiation: I; None in sessions of before it was kept.
        ends: of the trials by which P of the option before it was estimated, those in which its β held.
        ends_inside: how many of them end in I.
        moved: m between its goal now and when it was accepted first, where the skill after it has learned
            that goal anew, for where the hand takes hold.
    """

    segment: int
    formulation: int
    policy: Policy
    initiation: InitiationSet | None = None
    ends: int = 0
    ends_inside: int = 0
    moved: float = 0.0


@dataclass(frozen=True)
class Reproduced:
    """The whole task from perturbed starts, judged by where the objects end.

    Attributes:
        successes, trials, low, high: with Wilson's interval at 95 %.
        reproduced: whether at least α of them succeeded.
        outside: trials in which an option began outside its initiation set.
        outside_failed: how many of those failed.
        really: of watched trials, which are judged by what was seen, how many succeeded in the physics.
    """

    successes: int
    trials: int
    low: float
    high: float
    reproduced: bool
    outside: int = 0
    outside_failed: int = 0
    really: int | None = None


@dataclass(frozen=True)
class Kept:
    """Whose policy was the best of a skill that was not learned: it is in that formulation's evidence."""

    segment: int
    formulation: int
    successes: int
    trials: int


@dataclass(frozen=True)
class SessionFinished:
    """The end. ``advice`` names the skill that failed, what was tried and what to do next; else empty.

    Where a skill was not learnable, ``best`` says which policy came nearest.
    """

    reproduced: bool
    advice: str
    best: Kept | None = None


Event = (
    SessionStarted
    | Segmented
    | Decided
    | FormulationStarted
    | TrialFinished
    | PolicyUpdated
    | Converged
    | Evaluated
    | Reformulated
    | OptionLearned
    | Reproduced
    | SessionFinished
    | Skipped
)
