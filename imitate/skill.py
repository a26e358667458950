"""What a skill is, as data: abstraction, segment, formulation, cost terms, policy parameters."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from imitate.demonstration import HAND
from imitate.geometry import Array, read_only

Action = Literal["pose", "gripper"]
Gripping = Literal["untouched", "open", "missed", "slipped", "let go", "held"]
Term = Literal[
    "reach", "sight", "cost", "position", "angle", "position and angle", "moving", "holding", "place"
]


@dataclass(frozen=True)
class Abstraction:
    """⟨O_rel, o_ref⟩: which bodies matter, and in whose frame (the paper, section 4).

    Attributes:
        relevant: "hand" first, then relevant objects in the demonstration's order.
        reference: an object, never one of ``relevant``.
    """

    relevant: tuple[str, ...]
    reference: str

    def __str__(self) -> str:
        return f"⟨{{{', '.join(self.relevant)}}}, {self.reference}⟩"

    @property
    def carried(self) -> tuple[str, ...]:
        """The relevant bodies other than the hand."""
        return tuple(name for name in self.relevant if name != HAND)


@dataclass(frozen=True)
class Candidate:
    """An abstraction and how well it explains a segment (natural log)."""

    abstraction: Abstraction
    log_likelihood: float


@dataclass(frozen=True)
class Segment:
    """A stretch of the demonstration explained by one abstraction.

    Attributes:
        start, end: seconds since the first frame.
        abstraction: the one chosen, by the search or by the operator.
        alternatives: every candidate, best first, ``abstraction``'s own included.
        human: whether the operator chose the abstraction or a boundary.
    """

    start: float
    end: float
    abstraction: Abstraction
    alternatives: tuple[Candidate, ...] = ()
    human: bool = False


@dataclass(frozen=True)
class Decision:
    """What the operator decided about the segments.

    Attributes:
        kind: "move" a boundary, "relabel" a segment, "split" one, "merge" one with its next, "reset" all
            segments to those found, "undo" or "redo".
        segment: index of the segment (of the one before the boundary, for "move").
        time: seconds since the first frame, for "move" and "split".
        abstraction: for "relabel".
    """

    kind: Literal["move", "relabel", "split", "merge", "reset", "undo", "redo"]
    segment: int = 0
    time: float = 0.0
    abstraction: Abstraction | None = None

    def __str__(self) -> str:
        match self.kind:
            case "move":
                return f"end of skill {self.segment + 1} moved to {self.time:.2f} s"
            case "relabel":
                return f"skill {self.segment + 1} is {self.abstraction}"
            case "reset":
                return "everything as it was found"
            case "undo":
                return "undone"
            case "redo":
                return "done again"
            case "split":
                return f"skill {self.segment + 1} split at {self.time:.2f} s"
            case "merge":
                return f"skills {self.segment + 1} and {self.segment + 2} merged"


@dataclass(frozen=True)
class Formulation:
    """⟨S, A, cost⟩ in words: what is observed, what may be done. The cost follows from them.

    Attributes:
        segment: index of the segment.
        index: 0 for the first formulation of a segment, then counting up.
        abstraction: state = poses of its relevant bodies in its reference's frame.
        actions: ("pose",) or ("pose", "gripper").
        reason: why it was stated, in words for the operator.
    """

    segment: int
    index: int
    abstraction: Abstraction
    actions: tuple[Action, ...]
    reason: str


@dataclass(frozen=True)
class CostTerms:
    """What a trial cost, by term: terminal, squared acceleration, switches of the gripper."""

    terminal: float
    acceleration: float
    gripper: float

    @property
    def total(self) -> float:
        """The sum that policy improvement minimises."""
        return self.terminal + self.acceleration + self.gripper


@dataclass(frozen=True)
class Grasp:
    """What became of an object between the fingers during one option.

    Attributes:
        kind: "untouched"; touched, but the gripper stayed "open"; it closed, but the object was "missed";
            grasped, and then it "slipped", was "let go", or was "held" to the end.
        time: s into the option at which the last grip ended; 0 where there was none.
        duration: s, of the option.
        lift: m by which the object was then higher than at the option's start.
    """

    kind: Gripping
    time: float
    duration: float
    lift: float

    def __str__(self) -> str:
        """What happened, to be read after the object's name."""
        when = f"at {self.time:.1f} s of {self.duration:.1f}, {max(self.lift, 0) * 1e3:.0f} mm up"
        return {
            "untouched": "was never touched",
            "open": "was never grasped: the gripper stayed open",
            "missed": "was never grasped: the gripper closed, but not on it",
            "slipped": f"slipped from the grip {when}",
            "let go": f"was let go {when}",
            "held": "was held to the end",
        }[self.kind]


@dataclass(frozen=True)
class Miss:
    """One reason for which β does not hold at a trial's end.

    Attributes:
        term: a pose out of "reach"; a body out of the camera's "sight"; the terminal "cost" (faithful β); a
            body off its shown "position", "angle" or both, or still "moving"; the gripper "holding" what the
            hand is shown to leave; or what an earlier skill placed, off its "place".
        words: for the operator.
        body: which one; empty where it is none in particular.
        distance: m from the shown position in the reference's frame.
        angle: rad from the shown orientation there.
        grasp: how a carried body was grasped.
    """

    term: Term
    words: str
    body: str = ""
    distance: float = 0.0
    angle: float = 0.0
    grasp: Grasp | None = None

    def __str__(self) -> str:
        """Its words, with those of the grasp."""
        return f"{self.words}; {self.body} {self.grasp}" if self.grasp else self.words


@dataclass(frozen=True)
class Policy:
    """Parameters of a movement: a pose DMP in the reference's frame and a gripper DMP.

    Attributes:
        reference: the object whose pose at the option's start places the movement.
        duration: seconds of the movement.
        start: (7,) pose of the hand in the reference's frame as shown; settles the sign of quaternions alone.
        goal: (7,) pose of the hand in the reference's frame.
        pose_weights: forcing-term weights in the reference's frame, (n, 7) of position and quaternion or
            (n, 6) of position and rotation vector to the goal.
        gripper_weights: (m,) newtons; empty when the gripper is not an action and holds its last command.
        pose_noise, gripper_noise: like the weights, or empty; each kernel's is added while that kernel is the
            most active one (PI² with per-kernel noise).
        wait: seconds that the hand keeps still before it moves; the gripper's force begins with them.
        holds: whether the gripper's force ends at its last weight, since what is carried hangs in the air
            then; else it ends at 0 (the paper).
    """

    reference: str
    duration: float
    start: Array
    goal: Array
    pose_weights: Array
    gripper_weights: Array
    pose_noise: Array = field(default_factory=lambda: np.zeros((0, 7)))
    gripper_noise: Array = field(default_factory=lambda: np.zeros(0))
    wait: float = 0.0
    holds: bool = False

    def __post_init__(self) -> None:
        for name in ("start", "goal", "pose_weights", "gripper_weights", "pose_noise", "gripper_noise"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


def policy_ticks(policy: Policy, rate: float) -> tuple[int, int]:
    """Control ticks of a policy's wait and of its movement, at ``rate`` a second."""
    return round(policy.wait * rate), max(2, round(policy.duration * rate))


@dataclass(frozen=True)
class InitiationSet:
    """I of an option: the starts from which it is likely to succeed, as what was tried.

    Attributes:
        bodies, reference: whose poses a start is made of, and in whose frame.
        starts: (n, B, 7) those tried.
        succeeded: (n,) 1 where β held at the end, else 0.
        foretold: (n,) p of each start, learned from the others alone.
        mean: (B, 7) the mean start.
        decorrelation: (6B, 6B) takes deviations from it, m and rotation vectors in rad, to where distances
            count.
        width: of the kernel, there.
        doubt: weight of what is not known, against that of one trial at the same place.
        threshold: p from which a start is in I.
    """

    bodies: tuple[str, ...]
    reference: str
    starts: Array
    succeeded: Array
    foretold: Array
    mean: Array
    decorrelation: Array
    width: float
    doubt: float
    threshold: float

    def __post_init__(self) -> None:
        for name in ("starts", "succeeded", "foretold", "mean", "decorrelation"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def precision(self) -> tuple[int, int]:
        """How many succeeded, of those whose success the others foretell."""
        inside = self.foretold >= self.threshold
        return int(self.succeeded[inside].sum()), int(inside.sum())

    @property
    def recall(self) -> tuple[int, int]:
        """How many the others foretell, of those that succeeded."""
        good = self.succeeded > 0
        return int((self.foretold[good] >= self.threshold).sum()), int(good.sum())

    @property
    def failures(self) -> int:
        """How many of the starts failed."""
        return int(len(self.succeeded) - self.succeeded.sum())

    def __str__(self) -> str:
        """How good it is, for an operator."""
        failed = f"{self.failures} failed" if self.failures else "none failed"
        (right, called), (found, good) = self.precision, self.recall
        return (
            f"initiation set: precision {right}/{called}, recall {found}/{good} "
            f"({len(self.succeeded)} trials, {failed})"
        )
