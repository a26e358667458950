"""Learn in words: a formulation, the last reformulation, what would come next."""

from __future__ import annotations

from collections import Counter

from textual.content import Content

from imitate.events import Purpose
from imitate.session.progress import Attempt
from imitate.tui.attempts import Branch, branches
from imitate.tui.pace import trials_left
from imitate.tui.state import State
from imitate.tui.words import actions_in_words, duration_in_words, outcome, state_in_words, success_in_words

WHEN = {
    "next": "next, if the present formulation fails",
    "then": "after the next one, if that fails too",
    "to come": "once the skills before it are learned",
}
"""when a formulation would be tried, in more words than the tree has."""


def branch_words(branch: Branch) -> Content:
    """A formulation that may come."""
    abstraction, actions = branch.statement
    return Content("\n").join([
        Content.styled(f"Skill {branch.skill + 1}, not tried yet", "bold"),
        Content.assemble(("observe ", "bold $text-accent"), state_in_words(abstraction)),
        Content.assemble(("do ", "bold $text-accent"), actions_in_words(actions)),
        Content.assemble(("when ", "bold $text-accent"), WHEN[branch.when]),
    ])  # fmt: skip


def pace_words(attempt: Attempt, state: State) -> str:
    """How fast trials come and how long this formulation may still take."""
    rate = state.pace.rate
    if not rate or not state.running or state.pausing or attempt is not state.progress.present:
        return ""
    left = trials_left(attempt, state.progress.settings.learning) / rate
    return f", {rate:.1f} trials/s, at most {duration_in_words(left)} left for it"


def threshold(state: State) -> float | None:
    """C, where success is judged by the terminal cost."""
    learning = (state.progress.settings if state.progress.started else state.settings).learning
    return learning.cost_threshold if learning.judge == "cost" else None


def skip_question(state: State) -> str:
    """What giving the present formulation up would lead to."""
    present = state.progress.present
    assert present is not None
    stated = present.formulation
    after = [b for b in branches(state) if b.skill == stated.segment and b.when == "next"]
    if after:
        abstraction, actions = after[0].statement
        then = f"The next one is then tried: {abstraction} with {' and '.join(actions)}."
    elif stated.segment:
        then = f"It is the last one of this skill: the search goes back to skill {stated.segment}."
    else:
        then = "It is the last one: the skill is then not learnable, and the session ends."
    return (
        f"Give up formulation {stated.index + 1} of skill {stated.segment + 1}, {stated.abstraction} with "
        f"{' and '.join(stated.actions)}, after the present trials? {then}"
    )


def banner_words(state: State) -> str:
    """The last reformulation of the skill that is being learned; or that it stops, waits or has stopped."""
    if state.stopping:
        return "■ Stopping after the present trial."
    if state.skipping:
        return "■ Giving this formulation up after the present trials; its best policy is judged once."
    if state.pausing:
        return "■ Paused: no trial is begun after the present ones. g goes on."
    if state.resumable:
        count = sum(state.progress.counts.values())
        return f"■ The session stopped after {count} trials. g goes on from there; nothing is done twice."
    present = state.progress.present
    if not state.running or present is None or present.accepted:
        return ""
    given_up = [a for a in state.attempts if a.given_up]
    if not given_up or present.formulation.index == 0:
        return ""
    last = given_up[-1]
    return f"▲ Skill {last.formulation.segment + 1} is stated anew: {last.given_up}"


def attempt_words(state: State, attempt: Attempt | None) -> Content:
    """The formulation, its counters, its P against α."""
    if attempt is None:
        if not state.running:
            return Content("Nothing was learned.")
        seen = f" Observing the recording: {100 * state.observed:.0f} %." if state.kind == "recording" else ""
        return Content(f"Preparing.{seen}")
    stated = attempt.formulation
    count = Counter[Purpose](trial.purpose for trial in attempt.trials)
    alpha = state.progress.settings.learning.alpha
    rows = [
        ("", f"Skill {stated.segment + 1}, formulation {stated.index + 1}"),
        ("observe", state_in_words(stated.abstraction)),
        ("do", actions_in_words(stated.actions)),
        ("why", stated.reason),
        (
            "now",
            outcome(attempt, attempt is state.progress.present, state.running) + pace_words(attempt, state),
        ),
        ("trials", f"{attempt.explored} to learn, {count['choose']} to choose, {count['evaluate']} to judge"),
        ("updates", f"{len(attempt.updates)}" + (f": {attempt.converged}" if attempt.converged else "")),
    ]
    if attempt.trials:
        rows.append(("last", trial_words(attempt)))
    if attempt.given_up:
        rows.append(("given up", attempt.given_up))
    if attempt.evaluated:
        rows.append(("P", f"{success_in_words(attempt.evaluated)}, needed {alpha:.2f}"))
    else:
        rows.append(("P", f"not judged yet, needed {alpha:.2f}"))
    if attempt.learned and attempt.learned.initiation:
        rows.append(("starts", str(attempt.learned.initiation)))
    return Content("\n").join(
        Content.assemble((f"{name} ", "bold $text-accent"), value) if name else Content.styled(value, "bold")
        for name, value in rows
    )


def trial_words(attempt: Attempt) -> str:
    """The last trial: its cost by terms, and what went wrong."""
    trial = attempt.trials[-1]
    cost = trial.cost
    terms = f"{cost.terminal:.1f} end + {cost.acceleration:.1f} acceleration + {cost.gripper:.0f} gripper"
    return f"cost {cost.total:.1f} = {terms}" + ("" if trial.success else f"; {trial.failure}")
