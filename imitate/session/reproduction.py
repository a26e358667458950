"""A finished session's options, run again from new starts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from imitate import events
from imitate.demonstration import interpolated
from imitate.errors import FileError
from imitate.events import Event
from imitate.formats.session_log import read_session
from imitate.geometry import Array
from imitate.learning.option import Option
from imitate.learning.problem import formulate
from imitate.learning.reproduce import reproduce
from imitate.learning.trials import ExecutorFactory, Trials
from imitate.settings import settings_from_toml
from imitate.skill import Formulation, Segment
from imitate.world.robot_files import located
from imitate.world.scene import check_within_reach


def reproduce_session(
    path: Path,
    count: int,
    seed: int,
    factory: ExecutorFactory,
    shift: float | None = None,
    turn: float | None = None,
    robot: str = "",
    observe_trials: bool | None = None,
    poses: Array | None = None,
) -> Iterator[Event]:
    """Runs the options of a session from ``count`` perturbed starts.

    Args:
        path: the session.
        count: of the starts.
        seed: of the starts.
        factory: of what runs them.
        shift: m by which each object is moved at most; as the session's settings say otherwise.
        turn: degrees by which each is turned at most, likewise.
        robot: the TOML file beside which the robot's files are now, if not where they were.
        observe_trials: whether camera and tracker see the objects, likewise.
        poses: (K, 7) world poses about which the objects are moved, instead of those shown.

    Raises:
        FileError: not a session, or one in which some skill was not learned; names it.
        SceneError: the robot's files are missing or are not those recorded; or a pose is out of reach.
    """
    found = _finished(path)
    given = {"shift": shift, "turn": turn, "observe_trials": observe_trials}
    changed = {name: value for name, value in given.items() if value is not None}
    settings = settings_from_toml(found.started.settings)
    settings = settings.model_copy(update={"learning": settings.learning.model_copy(update=changed)})
    demonstration = interpolated(found.started.demonstration)
    segments = found.segments
    options = tuple(
        Option(formulate(demonstration, segments, formulation, settings), option.policy, option.initiation)
        for formulation, option in found.learned
    )
    scene = located(found.started.scene, robot)
    if poses is not None:
        scene = replace(scene, object_poses=poses)
        check_within_reach(scene, scene.object_names)
    with Trials(factory, scene, settings) as trials:
        seeds = np.random.SeedSequence(seed)
        yield from reproduce(demonstration, segments, options, trials, seeds, count)


@dataclass(frozen=True)
class _Finished:
    # A session in which every skill was learned: of each the formulation that was, and its option.
    started: events.SessionStarted
    segments: tuple[Segment, ...]
    learned: tuple[tuple[Formulation, events.OptionLearned], ...]


def _finished(path: Path) -> _Finished:
    started: events.SessionStarted | None = None
    segments: tuple[Segment, ...] = ()
    stated: dict[tuple[int, int], Formulation] = {}
    learned: dict[int, tuple[Formulation, events.OptionLearned]] = {}
    for event in read_session(path):
        match event:
            case events.SessionStarted():
                started = event
            case events.Segmented() | events.Decided():
                segments = event.segments
            case events.FormulationStarted(formulation=f):
                stated[f.segment, f.index] = f
                learned = {i: option for i, option in learned.items() if i < f.segment}
            case events.OptionLearned():
                learned[event.segment] = stated[event.segment, event.formulation], event
    if started is None:
        raise FileError(path, "holds no session", "Make one: imitate learn DEMONSTRATION")
    if missing := [i for i in range(max(len(segments), 1)) if i not in learned]:
        name = f"skill {missing[0] + 1}" + (f", {segments[missing[0]].abstraction}," if segments else "")
        raise FileError(
            path,
            f"{name} was not learned in this session, so there is no whole task to reproduce",
            f"Learn again with another seed: imitate learn {started.source} --seed {started.seed + 1}",
        )
    return _Finished(started, segments, tuple(learned.values()))
