"""Stacking from one filmed demonstration, the gripper's force to be discovered (sections 8.3.2 and 8.3.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from statistics import fmean, median, stdev
from typing import Any

import numpy as np

from imitate.experiments.sessions import learned
from imitate.experiments.stacking_figures import costs_figure
from imitate.experiments.table import Column, Result, Table
from imitate.experiments.work import Kind, Options, Outcome, Part
from imitate.settings import Settings

SEEDS = 10
FILMED = "stack.mcap"
PAPER = {(0, "pose"): (10, None), (1, "pose + gripper"): (25, 15.0), (2, "pose"): (10, None)}
"""(skill, actions) → trials, cost."""
NOTES = (
    "A row is one way to state a skill, over all seeds that came to it. P: trials from perturbed starts in "
    "which it succeeded, of all seeds together, and of the seed with the fewest. Trials: those spent on "
    "learning. Cost: the judged policy's mean over those starts, ± the standard deviation over seeds, and "
    "its terms: where things end, acceleration, 5 for each closing or opening.",
    "gripper_from_opening = false: as in the paper the force is discovered, though the fingers are filmed.",
)


def discovering(settings: Settings) -> Settings:
    """The settings, but that the gripper's force is not taken from the hand's opening.

    P is estimated over all starts, since those of many seeds are counted together.
    """
    learning = settings.learning.model_copy(update={"gripper_from_opening": False, "curtail": False})
    return settings.model_copy(update={"learning": learning})


def _parts(options: Options) -> Sequence[Part]:
    path, settings = options.fixtures / FILMED, discovering(options.settings)
    seeds = range(options.seeds or SEEDS)
    return [Part(f"seed-{seed}", partial(learned, path, settings, seed), (path,)) for seed in seeds]


def _result(_: Options, outcomes: Mapping[str, Outcome]) -> Result:
    sessions = [outcome for outcome in outcomes.values() if not outcome["error"]]
    attempts = stated(sessions)
    columns = (
        Column("skill", "skill"),
        Column("abstraction", "relevant, reference"),
        Column("actions", "actions"),
        Column("seeds", "accepted"),
        Column("p", "P"),
        Column("p_least", "least"),
        Column("paper_trials", "paper's trials"),
        Column("trials", "trials, median", "g"),
        Column("trials_most", "most"),
        Column("paper_cost", "paper's cost", ".0f"),
        Column("cost", "cost", ".1f", "cost_std"),
        Column("terminal", "ends", ".1f"),
        Column("acceleration", "acceleration", ".1f"),
        Column("gripper", "gripper", ".1f"),
    )
    rows = tuple(_row(*key, found) for key, found in attempts.items())
    table = Table("Skills of the filmed stacking (sections 8.3.2, 8.3.3)", columns, rows, NOTES)
    return Result(
        (table, whole_table(outcomes)),
        {"costs": lambda: costs_figure(attempts)},
        {
            "costs": "Cost of each trial: median, least and most over seeds, of each skill as first stated "
            "and as stated anew; and what the policy that was accepted cost from new starts."
        },
    )


Stated = dict[tuple[int, str, str], list[dict[str, Any]]]


def stated(sessions: Sequence[Outcome]) -> Stated:
    """(skill, abstraction, actions) → each time that the skill was stated so, in any session."""
    found: Stated = {}
    for session in sessions:
        for skill, attempts in enumerate(session["skills"]):
            for attempt in attempts:
                key = (skill, attempt["abstraction"], attempt["actions"])
                found.setdefault(key, []).append(attempt)
    return dict(sorted(found.items(), key=lambda item: (item[0][0], -len(item[1]), item[0][2])))


def _row(skill: int, abstraction: str, actions: str, attempts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    judged = [a for a in attempts if a["success"]]
    rates = [a["success"][0] / a["success"][1] for a in judged]
    trials = [len(a["explored"]) for a in attempts]
    costs = [a["cost"] for a in judged]
    means = [np.mean(a["judged"], axis=0) for a in judged if a["judged"]]
    terms = np.mean(means, axis=0).tolist() if means else [None] * 3
    paper = PAPER.get((skill, actions), (None, None))
    return {
        "skill": skill + 1,
        "abstraction": abstraction,
        "actions": actions,
        "seeds": [sum(a["accepted"] for a in attempts), len(attempts)],
        "p": [sum(a["success"][k] for a in judged) for k in (0, 1)],
        "p_least": judged[int(np.argmin(rates))]["success"] if judged else None,
        "paper_trials": paper[0],
        "trials": median(trials),
        "trials_most": max(trials),
        "paper_cost": paper[1],
        "cost": fmean(costs) if costs else None,
        "cost_std": stdev(costs) if len(costs) > 1 else None,
        "terminal": terms[0],
        "acceleration": terms[1],
        "gripper": terms[2],
    }


def whole_table(outcomes: Mapping[str, Outcome]) -> Table:
    """Whether the whole task was reproduced, a row a session."""
    columns = (
        Column("session", "session"),
        Column("done", "reproduced"),
        Column("starts", "starts"),
        Column("said", "where not, why"),
    )
    rows = [
        {
            "session": key,
            "done": "yes" if outcome.get("done") else "no",
            "starts": outcome.get("reproduced"),
            "said": outcome["error"] or outcome["advice"],
        }
        for key, outcome in outcomes.items()
    ]
    done = sum(bool(outcome.get("done")) for outcome in outcomes.values())
    return Table(f"The whole task: reproduced in {done} of {len(outcomes)} sessions", columns, tuple(rows))


KIND = Kind("Stacking: problems stated and stated anew", _parts, _result)
