"""What the trials of a formulation say of it: how often it succeeds, what it cost, what it fails of."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from imitate.demonstration import HAND
from imitate.events import Event, Evidence, Shortfall, Skipped, TrialFinished
from imitate.geometry import Array
from imitate.learning.initiation import initiation_set, start_of
from imitate.learning.option import Option
from imitate.learning.problem import Problem
from imitate.learning.runs import Learned
from imitate.settings import Learning
from imitate.skill import Miss, Policy, Term

_NEVER = ("untouched", "open", "missed")
_GRASPS = {
    "untouched": "was never touched",
    "open": "was never grasped",
    "missed": "was never grasped",
    "slipped": "slipped from the grip",
    "let go": "was let go elsewhere",
    "held": "was carried elsewhere",
}


@dataclass(frozen=True)
class _Judged:
    # A trial that counts towards P: its policy, its misses, and where hand and objects (K + 1, 7) were when
    # it began and when it ended.
    policy: Policy
    misses: tuple[Miss, ...]
    begin: Array
    end: Array


@dataclass
class Witness:
    """Remembers what the trials of one formulation came to, without their steps.

    Attributes:
        problem: the formulation's.
        costs: total costs of the exploring trials, in a list for each update that came before them.
        judged: those that count towards P.
        begun: (policy, (B, 7) start in the reference's frame, success) of every trial in which it began.
        skipped: whether the operator gave it up.
    """

    problem: Problem
    costs: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    judged: list[_Judged] = field(default_factory=list)
    begun: list[tuple[Policy, Array, bool]] = field(default_factory=list)
    skipped: bool = False

    def attend(self, course: Generator[Event, None, Learned]) -> Generator[Event, None, Learned]:
        """The course unchanged, its trials remembered."""
        while True:
            try:
                event = next(course)
            except StopIteration as end:
                learned: Learned = end.value
                return learned
            if isinstance(event, TrialFinished):
                self._remember(event)
            self.skipped |= isinstance(event, Skipped)
            yield event

    def _remember(self, trial: TrialFinished) -> None:
        if trial.purpose == "explore":
            self.costs[trial.update].append(trial.cost.total)
        policy, record = trial.policies[-1], trial.believed
        if trial.purpose == "prepare" or record is None:
            return
        if trial.purpose == "evaluate":
            begin, end = (
                np.vstack([record.hand_poses[[k]], record.object_poses[k]])
                for k in (max(record.option_starts[-1] - 1, 0), -1)
            )
            self.judged.append(_Judged(policy, trial.misses, begin, end))
        if len(record.option_starts) == len(trial.policies):
            start = start_of(record, self.problem.object_names, self.problem.formulation.abstraction)
            self.begun.append((policy, start, trial.success))

    def evidence(self, learned: Learned) -> Evidence:
        """What was seen of the policy that was learned."""
        success = learned.success  # of the last that were judged, where it was judged twice
        misses = [trial.misses for trial in self.judged if trial.policy is learned.policy][-success.trials :]
        return Evidence(
            successes=success.successes,
            trials=success.trials,
            low=success.interval[0],
            high=success.interval[1],
            explored=sum(map(len, self.costs.values())),
            best_costs=tuple(min(costs) for costs in self.costs.values()),
            mean_costs=tuple(float(np.mean(costs)) for costs in self.costs.values()),
            shortfalls=shortfalls(misses),
            policy=learned.policy,
            stopped=learned.stopped,
        )

    def option(self, learned: Learned, settings: Learning) -> Option:
        """The option that was learned, I from every trial that its policy ran in."""
        begun = [(start, ok) for policy, start, ok in self.begun if policy is learned.policy]
        ends = [t.end for t in self.judged if t.policy is learned.policy and not t.misses]
        starts, succeeded = np.array([start for start, _ in begun]), np.array([ok for _, ok in begun], float)
        abstraction = self.problem.formulation.abstraction
        return Option(
            self.problem,
            learned.policy,
            initiation_set(abstraction, starts, succeeded, settings),
            np.array(ends).reshape(len(ends), -1, 7),
        )

    def approached(self, before: Option, learned: Learned) -> Option:
        """The option before it, with the goal that was learned for it in this formulation."""
        begins = [t.begin for t in self.judged if t.policy is learned.policy]
        return replace(before, policy=learned.row[-2], ends=np.array(begins).reshape(len(begins), -1, 7))


def shortfalls(trials: Sequence[Sequence[Miss]]) -> tuple[Shortfall, ...]:
    """The misses of many trials, alike ones counted together, most frequent first."""
    alike: dict[tuple[str, Term, str], list[Miss]] = defaultdict(list)
    for miss in (miss for misses in trials for miss in misses):
        alike[miss.body, miss.term, miss.grasp.kind if miss.grasp else ""].append(miss)
    found = [
        Shortfall(
            body=body,
            term=term,
            grasp=grasp,
            starts=len(misses),
            distance=float(np.median([miss.distance for miss in misses])),
            angle=float(np.median([miss.angle for miss in misses])),
            words=misses[0].words,
        )
        for (body, term, grasp), misses in alike.items()
    ]
    return tuple(sorted(found, key=lambda s: -s.starts))


def strayed(evidence: Evidence, bodies: Sequence[str]) -> bool:
    """Whether carried bodies mostly did not come along with the hand: never grasped, or lost on the way."""
    lost = sum(s.starts for s in evidence.shortfalls if s.body in bodies and s.grasp in (*_NEVER, "slipped"))
    others = sum(s.starts for s in evidence.shortfalls if s.body in bodies and s.grasp in ("let go", "held"))
    return lost > others


def in_words(evidence: Evidence, same: float) -> str:
    """The evidence for the operator, on a line or two.

    Args:
        evidence: of a formulation.
        same: difference in cost below which it stayed as it was.
    """
    rate = f"{evidence.successes} of {evidence.trials} starts, {evidence.low:.2f}–{evidence.high:.2f}"
    rate += f", stopped: {evidence.stopped}" if evidence.stopped else ""
    parts = [rate, _costs_in_words(evidence, same), failings(evidence)]
    return "; ".join(part for part in parts if part)


def failings(evidence: Evidence) -> str:
    """The two most frequent failings in words; empty where there are none."""
    counted: Counter[str] = Counter()
    for shortfall in evidence.shortfalls:
        counted[_failing(shortfall)] += shortfall.starts
    return ", ".join(
        words + (f" in {count} of {evidence.trials}" if count < evidence.trials else "")
        for words, count in counted.most_common(2)
    )


def _costs_in_words(evidence: Evidence, same: float) -> str:
    if not evidence.best_costs:
        return ""
    first, last = evidence.best_costs[0], min(evidence.best_costs)
    trials = f"{evidence.explored} trial" + "s" * (evidence.explored > 1)
    if first - last < same:
        return f"the cost stayed at {last:.0f} over {trials}" if evidence.explored > 1 else f"cost {last:.0f}"
    return f"the cost fell from {first:.0f} to {last:.0f} over {trials}"


def _failing(shortfall: Shortfall) -> str:
    body = f"the {shortfall.body}" if shortfall.body == HAND else shortfall.body
    if shortfall.grasp:
        return f"{body} {_GRASPS[shortfall.grasp]}"
    return {
        "position": f"{body} ends too far off",
        "angle": f"{body} ends turned too far",
        "position and angle": f"{body} ends too far off and turned too far",
        "moving": f"{body} is still moving",
        "holding": f"{body} is not let go",
        "reach": "a pose is out of reach",
        "sight": "an object is not seen",
        "cost": "the terminal cost is too high",
        "place": "an object is not where it was shown to be by then",
    }[shortfall.term]
