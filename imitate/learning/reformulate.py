"""The search over formulations (the paper's Algorithm 1), over all segments in order.

For the segment at hand: its best abstraction without the gripper, then with it, then the next abstraction
without, with …; when none is left, the search goes back to the segment before and takes that one's next.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field, replace

import numpy as np

from imitate.demonstration import Demonstration
from imitate.events import Event, Evidence, FormulationStarted, Kept, OptionLearned, Reformulated
from imitate.learning.evidence import Witness, failings, in_words, strayed
from imitate.learning.improve import Improvement
from imitate.learning.initiation import probability, seen_from
from imitate.learning.option import Option
from imitate.learning.problem import Problem, formulate
from imitate.learning.runs import Learned
from imitate.learning.statements import Statement, dropped_in_words, statements
from imitate.learning.trials import Trials
from imitate.record import Start
from imitate.settings import Learning
from imitate.skill import Formulation, Policy, Segment
from imitate.world.robot import robot_of


@dataclass(frozen=True)
class Search:
    """What the search came to: the options; if they are not one for each segment, why, and what was best.

    Attributes:
        options: those accepted, of the first segments.
        given_up: which skill is not learnable, and why; empty when every one was learned.
        best: the best policy of that skill; None where none was tried.
    """

    options: tuple[Option, ...]
    given_up: str = ""
    best: Kept | None = None


@dataclass
class _Attempts:
    # What is still to be tried for a segment, and what came of what was.
    left: list[Statement]
    tried: list[tuple[Problem, Evidence]] = field(default_factory=list)
    since: int = 0  # how many had been tried when the search last went back beyond this segment


def learn_options(
    demonstration: Demonstration, segments: tuple[Segment, ...], trials: Trials, shown: Start, seed: int
) -> Generator[Event, None, Search]:
    """Learns an option for each segment; yields every event on the way."""
    learning = trials.settings.learning
    fingers = robot_of(trials.spec)
    attempts = [_Attempts(_to_try(segment, learning)) for segment in segments]
    options: list[Option] = []
    reason, i = "as the demonstration was segmented", 0
    for _ in range(learning.formulations):
        i = len(options)
        abstraction, actions = attempts[i].left.pop(0)
        formulation = Formulation(i, len(attempts[i].tried), abstraction, actions, reason)
        yield FormulationStarted(formulation)
        problem = formulate(demonstration, segments, formulation, trials.settings, fingers.closing_time)
        prefix = tuple(option.policy for option in options)
        learned, witness = yield from _learn(problem, prefix, attempts[i], trials, shown, seed)
        if learned.accepted:
            if len(learned.row) > 1:
                before = options.pop()
                options.append(witness.approached(before, learned))
                yield _learned(options, before.policy)
            options.append(witness.option(learned, learning))
            yield _learned(options)
            if len(options) == len(segments):
                return Search(tuple(options))
            reason = "the skills before it are learned"
            i = len(options)
            continue
        evidence = attempts[i].tried[-1][1]
        found = in_words(evidence, learning.converged_below)
        change = _change(formulation, attempts, segments) if learning.reformulate else "it is not stated anew"
        failed = "the operator skipped it" if witness.skipped else _what_failed(formulation, evidence)
        reason = f"{failed} ({found}): {change}"
        yield Reformulated(i, formulation.index, reason, evidence)
        if not learning.reformulate:
            return _given_up(tuple(options), segments, i, attempts[i], "it is tried as first stated alone")
        while not attempts[len(options)].left:
            if not options:
                return _given_up((), segments, i, attempts[i], "every formulation was tried")
            again = attempts[len(options)]
            again.left, again.since = _to_try(segments[len(options)], learning), len(again.tried)
            options.pop()
    limit = f"the limit of {learning.formulations} formulations is reached"
    return _given_up(tuple(options), segments, i, attempts[i], limit)


def _to_try(segment: Segment, learning: Learning) -> list[Statement]:
    return statements(segment, learning)


def _learn(
    problem: Problem,
    prefix: tuple[Policy, ...],
    attempts: _Attempts,
    trials: Trials,
    shown: Start,
    seed: int,
) -> Generator[Event, None, tuple[Learned, Witness]]:
    # One formulation, and what its events show of it.
    witness = Witness(problem)
    mean = _first_mean(problem, attempts, trials.settings.learning)
    course = Improvement(problem, prefix, mean, trials, np.random.SeedSequence(seed)).run(shown)
    learned = yield from witness.attend(course)
    attempts.tried.append((problem, witness.evidence(learned)))
    return learned, witness


def _first_mean(problem: Problem, attempts: _Attempts, learning: Learning) -> Policy:
    # Pose weights start from the policy just learned for the same abstraction; gripper weights do not.
    tried = attempts.tried if learning.keep_failed else attempts.tried[attempts.since :]
    for before, evidence in reversed(tried):
        if before.formulation.abstraction == problem.formulation.abstraction:
            if not (evidence.successes or learning.keep_failed):
                break
            none = np.zeros((0, 7))
            weights = evidence.policy.pose_weights
            return replace(problem.imitated, pose_weights=weights, pose_noise=none)
    return problem.imitated


def _learned(options: list[Option], aimed: Policy | None = None) -> OptionLearned:
    # Also whether the option before the new one ends where the new one is likely to succeed, and how far from
    # where it ``aimed`` before the new one aims.
    new, formulation = options[-1], options[-1].problem.formulation
    ends = options[-2].ends if len(options) > 1 else np.zeros((0, 0, 7))
    inside = 0
    if new.initiation:
        names, abstraction = new.problem.object_names, formulation.abstraction
        p = [probability(new.initiation, seen_from(abstraction, names, end)) for end in ends]
        inside = sum(chance >= new.initiation.threshold for chance in p)
    moved = float(np.linalg.norm(new.policy.goal[:3] - aimed.goal[:3])) if aimed else 0.0
    return OptionLearned(
        formulation.segment, formulation.index, new.policy, new.initiation, len(ends), inside, moved
    )


def _what_failed(failed: Formulation, evidence: Evidence) -> str:
    carried = failed.abstraction.carried
    if not carried:
        return "the hand's path alone does not do it"
    names = " and ".join(carried)
    return f"{names} did not {'follow the hand' if strayed(evidence, carried) else 'end where shown'}"


def _change(failed: Formulation, attempts: list[_Attempts], segments: tuple[Segment, ...]) -> str:
    # What is tried next, for the operator.
    left = attempts[failed.segment].left
    if left and left[0][0] == failed.abstraction:
        return "adding the gripper's force to the actions"
    if left:
        lost = dropped_in_words(segments[failed.segment], left[0][0])
        return f"trying the next abstraction, {left[0][0]}" + (f": {lost}" if lost else "")
    if failed.segment:
        before = segments[failed.segment - 1].abstraction
        return f"no formulation is left, going back to skill {failed.segment}, {before}"
    return "no formulation is left"


def _given_up(
    options: tuple[Option, ...], segments: tuple[Segment, ...], i: int, attempts: _Attempts, why: str
) -> Search:
    # The end of the search, in words, with the best policy of the skill that it ended at.
    skill = f"skill {i + 1}, {segments[i].abstraction}, is not learnable, because {why}"
    if not attempts.tried:
        return Search(options, f"{skill} before it.")
    lines = []
    for problem, evidence in attempts.tried:
        f = problem.formulation
        tail = f" ({words})" if (words := failings(evidence)) else ""
        rate = f"{evidence.successes} of {evidence.trials} starts"
        lines.append(f"{f.abstraction} with {' + '.join(f.actions)}: {rate}{tail}")
    problem, best = max(attempts.tried, key=lambda t: t[1].successes / t[1].trials)
    index = problem.formulation.index
    kept = f"The best policy, of formulation {index + 1} ({best.successes} of {best.trials}), is kept."
    return Search(
        options,
        f"{skill}: {'; '.join(lines)}. {kept}",
        Kept(i, index, best.successes, best.trials),
    )
