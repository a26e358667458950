"""One demonstrated reach played to blocks all over the table, by each form of primitives (Appendix B)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from imitate.demonstration import Demonstration, in_table_frame, interpolated
from imitate.experiments.dmp_formulations_figures import Mask, arrows_figure, shapes_figure
from imitate.experiments.table import Column, Result, Table
from imitate.experiments.work import Kind, Options, Outcome, Part
from imitate.formats.demonstrations import read_demonstration
from imitate.geometry import Array, compose, from_yaw
from imitate.learning.following import Followed, follow, reachable, reshaped
from imitate.learning.problem import formulate
from imitate.policy.dmp import imitate, response, rollout, scaling
from imitate.segmentation import segment
from imitate.settings import Settings, World
from imitate.skill import Formulation, Policy
from imitate.world.kinematics import Arm
from imitate.world.mounting import place_base
from imitate.world.robot import load_robot

FILE = "human_stack.npz"
BAXTER = "tests/world/baxter.toml"
PLACES = np.linspace(-0.25, 0.25, 10), np.linspace(-0.18, 0.18, 7)
"""m, along x and y from where the block was shown."""
TURNS = np.linspace(-90, 90, 7)
"""degrees by which it is turned from there."""
FORMS: dict[str, tuple[str, str]] = {
    "original": ("original", "quaternion"),
    "Hoffmann": ("hoffmann", "quaternion"),
    "Hoffmann, log map": ("hoffmann", "log"),
}
PAPER = {"original": 5.92, "Hoffmann": 33.47}
"""% of 490 poses, Baxter."""
FACTORS = (1.0, 3.0, 0.1, -1.0)
"""times the way from start to goal that was shown, of the figure that shows why."""
COLUMNS = (
    Column("robot", "robot"),
    Column("form", "form"),
    Column("learning", "learning"),
    Column("paper", "paper (%)", ".2f"),
    Column("reached", "reached"),
    Column("percent", "%", ".1f"),
    Column("of_possible", "of those within reach (%)", ".1f"),
    Column("possible", "within reach"),
    Column("trials", "trials, median", "g"),
)


def play(robot: str, form: str, column: int, file: Path, settings: Settings) -> Outcome:
    """Which poses of a column of the grid are reached, which after learning, and which can be at all."""
    forms, orientation = FORMS[form]
    policy = settings.policy.model_copy(update={"form": forms, "orientation": orientation})
    settings = settings.model_copy(update={"policy": policy})
    shown, reach = _shown_reach(file, settings)
    base, home = _stand(robot, file, settings.world)
    arm = Arm(load_robot(robot))
    reached, possible, learned, trials = [], [], [], []
    try:
        for k, block in enumerate(_blocks(shown.pose_of(reach.reference)[0], column)):
            rng = np.random.default_rng([column, k])

            def tried(candidate: Policy, block: Array = block) -> Followed:
                return follow(candidate, arm, base, home, block, settings)

            came = tried(reach).arrived(settings.world)
            goal = compose(block, reach.goal)
            can = came or reachable(arm, base, home, goal, rng, settings.world)
            found, spent = reshaped(reach, tried, rng, settings) if can and not came else (None, 0)
            reached.append(came)
            possible.append(can)
            learned.append(came or found is not None)
            trials.append(spent)
    finally:
        arm.close()
    return {"reached": reached, "possible": possible, "learned": learned, "trials": trials}


@lru_cache(maxsize=4)
def _stand(robot: str, file: Path, world: World) -> tuple[Array, Array]:
    # The base (7,) and the arm's joints (A,) at the start, as for the demonstration itself.
    shown = interpolated(in_table_frame(read_demonstration(file)))
    return place_base(load_robot(robot), shown, world)


def shapes(file: Path, settings: Settings) -> Outcome:
    """One coordinate of the shown reach, played to other goals by both forms; and where the hand starts."""
    shown, reach = _shown_reach(file, settings)
    s = settings.policy
    ticks = round(reach.duration * settings.world.control_rate)
    t = np.linspace(0, reach.duration, ticks)
    way = np.stack([np.interp(t, shown.t - shown.t[0], column) for column in shown.hand.T])[1]
    courses: dict[str, list[list[float]]] = {}
    for form in ("original", "hoffmann"):
        shape = response(ticks, s.pose_kernels, s.phase_decay, s.stiffness, form == "original")
        start, end = way[:1], way[-1:]
        weights = imitate(shape, way[:, None], end)
        courses[form] = []
        for factor in FACTORS:
            goal = start + factor * (end - start)
            scale = scaling(start, goal, end - start) if form == "original" else np.ones(1)
            courses[form].append(rollout(shape, start, goal, scale * weights)[::5, 0].tolist())
    from_block = shown.hand[0, :2] - shown.pose_of(reach.reference)[0, :2]
    return {"t": t[::5].tolist(), "courses": courses, "start": from_block.tolist()}


def _shown_reach(file: Path, settings: Settings) -> tuple[Demonstration, Policy]:
    # The demonstration on the table, and its first skill as it was imitated.
    shown = interpolated(in_table_frame(read_demonstration(file)))
    segments = segment(shown, settings.segmentation)
    stated = Formulation(0, 0, segments[0].abstraction, ("pose",), "as the demonstration was segmented")
    return shown, formulate(shown, segments, stated, settings).imitated


def _blocks(shown: Array, column: int) -> list[Array]:
    x = PLACES[0][column]
    return [
        compose(from_yaw(shown[:3] + np.array([x, y, 0]), np.deg2rad(turn)), [0, 0, 0, *shown[3:]])
        for y in PLACES[1]
        for turn in TURNS
    ]


def _robots(options: Options) -> dict[str, str]:
    baxter = options.fixtures.parent / BAXTER
    found = {"Panda": "panda"}
    if options.robot:
        found |= {Path(options.robot).stem: options.robot}
    elif baxter.exists() and (options.data / "baxter").exists():
        found |= {"Baxter": str(baxter)}
    return found


def _parts(options: Options) -> Sequence[Part]:
    file, s = options.fixtures / FILE, options.settings
    played = [
        Part(_key(name, form, column), partial(play, robot, form, column, file, s), (file,))
        for name, robot in _robots(options).items()
        for column in range(len(PLACES[0]))
        for form in FORMS
    ]
    return [Part("shapes", partial(shapes, file, s), (file,)), *played]


def _key(robot: str, form: str, column: int) -> str:
    return f"{robot}-{form.replace(', ', '-').replace(' ', '-')}-{column}"


def _whole(outcomes: Mapping[str, Outcome], robot: str, form: str) -> Outcome:
    # Of all columns, in the order of the grid.
    columns = [outcomes[_key(robot, form, column)] for column in range(len(PLACES[0]))]
    return {name: [value for each in columns for value in each[name]] for name in columns[0]}


def _result(options: Options, outcomes: Mapping[str, Outcome]) -> Result:
    robots = _robots(options)
    found = {(name, form): _whole(outcomes, name, form) for name in robots for form in FORMS}
    possible = {name: np.any([found[name, form]["possible"] for form in FORMS], axis=0) for name in robots}
    rows = [
        _row(name, form, found[name, form], possible[name], after)
        for name in robots
        for form in FORMS
        for after in (False, True)
    ]
    table = Table(
        "490 block poses from one demonstration (Appendix B)", COLUMNS, tuple(rows), _notes(options.settings)
    )
    shapes = outcomes["shapes"]
    maps = {
        f"map-{name}": partial(
            arrows_figure, _panels(name, found, possible[name]), PLACES, TURNS, shapes["start"]
        )
        for name in robots
    }
    captions = {
        f"map-{name}": f"{name}: where the block is reached, an arrow a pose, by place and direction."
        for name in robots
    }
    return Result(
        (table,),
        maps | {"why": lambda: shapes_figure(shapes, FACTORS)},
        captions
        | {
            "why": "One coordinate of the reach, to its own goal (dots) and to others. The original form "
            "scales the whole shape by the way to the goal: it blows up where the shown way was shorter, is "
            "lost where the goal is near, and turns round with the sign.",
        },
    )


def _notes(settings: Settings) -> tuple[str, ...]:
    world = settings.world
    x, y = PLACES
    return (
        f"{len(x)} × {len(y)} places, {x[0]:+.2f} … {x[-1]:+.2f} m along x and {y[0]:+.2f} … {y[-1]:+.2f} m "
        f"along y from where it was shown, and {len(TURNS)} turns, {TURNS[0]:+.0f} … {TURNS[-1]:+.0f}°.",
        f"Reached: the arm follows the whole movement, {world.control_rate} poses a second, each within "
        f"{world.reach_tolerance * 1e3:.0f} mm and {world.reach_angle:g} rad, no joint beyond its limits, "
        "the hand not below the table, and ends at the grasp. Within reach: inverse kinematics finds joints "
        "for the grasp, from any of 21 starts, or a movement gets there.",
        "Learning: PI^BB over how much each channel keeps of the shown shape, in kinematics, at most "
        f"{_budget(settings)} trials, of the poses that are within reach but not reached at once.",
    )


def _panels(
    robot: str, found: Mapping[tuple[str, str], Outcome], possible: Mask
) -> dict[str, tuple[Mask, Mask]]:
    # Title of each panel → which poses are reached, and which are within reach.
    panels = {form: (np.array(found[robot, form]["reached"]), possible) for form in FORMS}
    best = "Hoffmann, log map"
    return panels | {f"{best}, learned": (np.array(found[robot, best]["learned"]), possible)}


def _row(robot: str, form: str, outcome: Outcome, possible: Mask, after: bool) -> dict[str, Any]:
    came = outcome["learned" if after else "reached"]
    spent = [n for n in outcome["trials"] if n]
    return {
        "robot": robot,
        "form": form,
        "learning": "PI^BB" if after else "none",
        "paper": None if after else PAPER.get(form),
        "reached": [sum(came), len(came)],
        "percent": 100 * sum(came) / len(came),
        "of_possible": 100 * sum(came) / int(possible.sum()),
        "possible": [int(possible.sum()), len(came)],
        "trials": median(spent) if after and spent else None,
    }


def _budget(settings: Settings) -> int:
    s = settings.learning
    return s.first_rollouts + s.rollouts * (s.updates - 1)


KIND = Kind("Forms of movement primitives, to 490 block poses", _parts, _result)
