"""Stacking learned from poses that were seen off, without and with the goal among what is learned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import fmean, median, stdev
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from imitate.experiments.goal_learning_figures import errors_figure
from imitate.experiments.sessions import learned
from imitate.experiments.table import Column, Result, Table
from imitate.experiments.work import Kind, Options, Outcome, Part
from imitate.formats.demonstrations import read_demonstration, write_demonstration
from imitate.settings import Settings

SEEDS = 2
FILE = "human_stack.npz"
OFF = (0.0, 0.01, 0.02)
"""m by which all objects are seen off in the demonstration, in a direction that the seed draws."""
EVALUATION_STARTS = 10
"""perturbed starts over which P is estimated here: half of the default, to save time."""
WAYS: dict[str, dict[str, float]] = {
    "without": {"correct_goals": False},
    "with": {"grasp_noise": 0.01, "correct_goals": True},
}
"""settings of learning; m."""
NOTES = (
    "All objects are seen off by that much, in one direction that the seed draws, as by a camera out of "
    "place; trials are in the world as it is. Terminal cost: of the carry's last policy, the mean over its "
    "starts, 100 a metre and 11 a unit of the quaternion, ± the standard deviation over seeds. P: the "
    f"carry's, of all seeds together, {EVALUATION_STARTS} starts each; none where the reach was given up. "
    "New starts: of the whole task; none succeeds where a skill was not learned.",
)


def learn_off(metres: float, way: str, seed: int, file: Path, settings: Settings) -> Outcome:
    """A session from the demonstration with its objects seen off."""
    changed = {"evaluation_starts": EVALUATION_STARTS, "curtail": False} | WAYS[way]
    learning = settings.learning.model_copy(update=changed)
    settings = settings.model_copy(update={"learning": learning})
    shown = read_demonstration(file)
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    objects = shown.objects.copy()
    objects[..., :2] += metres * np.array([np.cos(angle), np.sin(angle)])
    with TemporaryDirectory() as folder:
        path = Path(folder) / file.name
        write_demonstration(replace(shown, objects=objects), path)
        return learned(path, settings, seed)


def _parts(options: Options) -> Sequence[Part]:
    file = options.fixtures / FILE
    return [
        Part(_key(metres, way, seed), partial(learn_off, metres, way, seed, file, options.settings), (file,))
        for seed in range(options.seeds or SEEDS)
        for metres in OFF
        for way in WAYS
    ]


def _key(metres: float, way: str, seed: int) -> str:
    return f"{metres * 1e3:g}mm-{way}-{seed}"


def _result(options: Options, outcomes: Mapping[str, Outcome]) -> Result:
    seeds = range(options.seeds or SEEDS)
    found = {
        (metres, way): [outcomes[_key(metres, way, seed)] for seed in seeds] for metres in OFF for way in WAYS
    }
    starts = options.settings.learning.reproduction_starts
    rows = tuple(_row(metres, way, sessions, starts) for (metres, way), sessions in found.items())
    columns = (
        Column("off", "seen off (mm)", "g"),
        Column("goals", "goal learning"),
        Column("done", "reproduced"),
        Column("whole", "new starts"),
        Column("p", "P of the carry"),
        Column("terminal", "terminal cost", ".1f", "terminal_std"),
        Column("trials", "trials, median", "g"),
    )
    return Result(
        (Table("Goals learned as perceived poses get worse", columns, rows, NOTES),),
        {"errors": lambda: errors_figure(rows)},
        {
            "errors": "Terminal cost of the carry and share of new starts from which the whole task "
            "succeeds, over how far off the objects were seen; bars: one standard deviation over seeds."
        },
    )


def _row(metres: float, way: str, sessions: Sequence[Outcome], starts: int) -> dict[str, Any]:
    carries = [carry for session in sessions if (carry := last_carry(session))]
    terminal = [float(np.mean(carry["judged"], axis=0)[0]) for carry in carries]
    whole = [session["reproduced"] for session in sessions if session.get("reproduced")]
    return {
        "off": metres * 1e3,
        "goals": way,
        "done": [sum(bool(session.get("done")) for session in sessions), len(sessions)],
        "whole": [sum(each[0] for each in whole), starts * len(sessions)],
        "p": [sum(carry["success"][k] for carry in carries) for k in (0, 1)] if carries else None,
        "terminal": fmean(terminal) if terminal else None,
        "terminal_std": stdev(terminal) if len(terminal) > 1 else None,
        "trials": median(len(carry["explored"]) for carry in carries) if carries else None,
    }


def last_carry(session: Outcome) -> dict[str, Any] | None:
    """The last formulation of the skill after the reach, if it came to be judged."""
    skills = session.get("skills", [])
    attempts = skills[1] if len(skills) > 1 else []
    judged = [attempt for attempt in attempts if attempt["judged"] and attempt["success"]]
    last: dict[str, Any] | None = judged[-1] if judged else None
    return last


KIND = Kind("Goal learning", _parts, _result)
