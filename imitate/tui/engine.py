"""What the application asks of the rest of imitate. Tests hand in their own.

Everything heavy is imported when it is first needed, so that the first picture comes at once.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from imitate.demonstration import Demonstration
from imitate.errors import ImitateError
from imitate.events import Event, Reproduced
from imitate.settings import Settings
from imitate.skill import Decision, Segment
from imitate.tui import teaching
from imitate.tui.again import Check, Runs
from imitate.tui.album import Shot, Wanted
from imitate.tui.files import Preview, first_picture, kind_of, look, read
from imitate.tui.film import Film
from imitate.tui.series import Series
from imitate.tui.sighting import Sighting
from imitate.tui.state import Interval
from imitate.tui.teaching import Resumed, Skip, Stop, Task

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from imitate.formats.kind import Kind
    from imitate.formats.mapping import Mapping
    from imitate.segmentation import Doubt
    from imitate.tui.again import Report

    Image = NDArray[np.uint8]


def cut(demonstration: Demonstration, settings: Settings) -> tuple[Segment, ...]:
    """Segments as the search finds them."""
    from imitate.segmentation import segment

    return segment(demonstration, settings.segmentation)


def decide(
    found: tuple[Segment, ...],
    decisions: tuple[Decision, ...],
    demonstration: Demonstration,
    settings: Settings,
) -> tuple[Segment, ...]:
    """Segments after the operator's decisions."""
    from imitate.segmentation import apply_decisions

    return apply_decisions(found, decisions, demonstration, settings.segmentation)


def changes(
    demonstration: Demonstration, segments: tuple[Segment, ...], settings: Settings
) -> tuple[Interval, ...]:
    """From when to when, with 90 % probability, the motion changes from each segment to the next, seconds."""
    from imitate.segmentation import changes as posteriors

    return tuple(p.interval() for p in posteriors(demonstration, segments, settings.segmentation))


def doubts(
    demonstration: Demonstration,
    found: tuple[Segment, ...],
    segments: tuple[Segment, ...],
    settings: Settings,
) -> tuple[Doubt, ...]:
    """Where segments explain the motion far less well than those found."""
    from imitate.segmentation import doubts as doubted

    return doubted(demonstration, found, segments, settings.segmentation)


def along(demonstration: Demonstration, settings: Settings) -> Series:
    """What each frame says for each object to move along with the hand rather than stay, in nats."""
    from imitate.segmentation.robust import RobustScore

    score = RobustScore(demonstration, settings.segmentation)
    return Series(demonstration.object_names, score.times, tuple(score.said.T))


def split_time(demonstration: Demonstration, segment: Segment, settings: Settings) -> float:
    """Where a segment is best split, seconds since the first frame."""
    from imitate.segmentation import split_time as best

    return best(demonstration, segment, settings.segmentation)


def write_decisions(path: Path, decisions: tuple[Decision, ...]) -> None:
    """Writes the operator's decisions to a new file."""
    from imitate.formats.decisions import write_decisions as write

    write(path, decisions)


def recorded(path: Path) -> Iterator[Event]:
    """The events of a session's file, without the physics steps."""
    from imitate.formats.session_log import read_session

    return read_session(path, steps=False)


def observe(task: Task, should_stop: Stop) -> Iterator[Sighting | str | Demonstration]:
    """The frames of a recording as they are tracked, some at a time, notes of it, then what was seen."""
    from imitate.tui.child import in_child

    return in_child(teaching.observe, task, should_stop)


def learn(task: Task, should_stop: Stop, should_wait: Stop, to_skip: Skip) -> Iterator[float | Event]:
    """The events of a session, from a process of its own; before them, of a recording, the
    shares of it that were tracked."""
    from imitate.tui.child import in_child

    return in_child(teaching.learn, task, should_stop, should_wait, to_skip)


def resume(task: Resumed, should_stop: Stop, should_wait: Stop, to_skip: Skip) -> Iterator[Event]:
    """All events of a session that was stopped or cut, those recorded first."""
    from imitate.tui.child import in_child

    return in_child(teaching.resume, task, should_stop, should_wait, to_skip)


def films(log: Path, should_stop: Stop) -> Iterator[Film]:
    """A session's trials, those whose steps it holds, as they are read."""
    from imitate.tui.child import in_child
    from imitate.tui.repeat import read_films

    return in_child(read_films, log, should_stop)


def reproduce(runs: Runs, should_stop: Stop) -> Iterator[Film | Reproduced]:
    """The learned task from new starts: each trial, then the result."""
    from imitate.tui.child import in_child
    from imitate.tui.repeat import run_starts

    return in_child(run_starts, runs, should_stop)


def pictures(wanted: Wanted, should_stop: Stop) -> Iterator[Shot]:
    """A recording's pictures, as they are read."""
    from imitate.tui.album import read_pictures
    from imitate.tui.child import in_child

    return in_child(read_pictures, wanted, should_stop)


def verify(check: Check, should_stop: Stop) -> Iterator[float | Report]:
    """Shares of a session's trials that were run again and compared, then what was found."""
    from imitate.tui.child import in_child
    from imitate.tui.repeat import verify as work

    return in_child(work, check, should_stop)


def view(log: Path, should_stop: Stop) -> Iterator[Path]:
    """Rerun's file of a session, made where there is none."""
    from imitate.tui.child import in_child
    from imitate.tui.repeat import write_view

    return in_child(write_view, log, should_stop)


def has_display() -> bool:
    """Whether a window can be opened here."""
    elsewhere = sys.platform != "linux"
    return elsewhere or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_viewer(path: Path) -> None:
    """Starts Rerun's viewer on a file, as a program of its own.

    Raises:
        ImitateError: the program is not there.
    """
    program = shutil.which("rerun", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if program is None:
        raise ImitateError(f"The program rerun is not installed here. Look at {path} where it is.")
    quiet = subprocess.DEVNULL
    subprocess.Popen([program, str(path)], stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True)


@dataclass(frozen=True)
class Engine:
    """The functions above, so that tests can hand in others."""

    kind_of: Callable[[Path], Kind] = kind_of
    look: Callable[[Path], Preview] = look
    read: Callable[[Path, list[str]], Demonstration] = read
    first_picture: Callable[[Path, Settings], Image] = first_picture
    cut: Callable[[Demonstration, Settings], tuple[Segment, ...]] = cut
    decide: Callable[
        [tuple[Segment, ...], tuple[Decision, ...], Demonstration, Settings], tuple[Segment, ...]
    ] = decide
    changes: Callable[[Demonstration, tuple[Segment, ...], Settings], tuple[Interval, ...]] = changes
    doubts: Callable[
        [Demonstration, tuple[Segment, ...], tuple[Segment, ...], Settings], tuple[Doubt, ...]
    ] = doubts
    along: Callable[[Demonstration, Settings], Series] = along
    split_time: Callable[[Demonstration, Segment, Settings], float] = split_time
    write_decisions: Callable[[Path, tuple[Decision, ...]], None] = write_decisions
    recorded: Callable[[Path], Iterator[Event]] = recorded
    observe: Callable[[Task, Stop], Iterator[Sighting | str | Demonstration]] = observe
    learn: Callable[[Task, Stop, Stop, Skip], Iterator[float | Event]] = learn
    resume: Callable[[Resumed, Stop, Stop, Skip], Iterator[Event]] = resume
    films: Callable[[Path, Stop], Iterator[Film]] = films
    reproduce: Callable[[Runs, Stop], Iterator[Film | Reproduced]] = reproduce
    pictures: Callable[[Wanted, Stop], Iterator[Shot]] = pictures
    verify: Callable[[Check, Stop], Iterator[float | Report]] = verify
    view: Callable[[Path, Stop], Iterator[Path]] = view
    has_display: Callable[[], bool] = has_display
    open_viewer: Callable[[Path], None] = open_viewer


def with_mapping(source: Path, mapping: Mapping) -> Engine:
    """An engine for which ``source`` is a demonstration whose columns, topics or frames mean what is said."""

    def kind(path: Path) -> Kind:
        return "demonstration" if path == source else kind_of(path)

    def read_mapped(path: Path, notes: list[str]) -> Demonstration:
        return read(path, notes, mapping if path == source else None)

    def look_mapped(path: Path) -> Preview:
        return look(path, mapping) if path == source else look(path)

    def learn_mapped(task: Task, stop: Stop, wait: Stop, to_skip: Skip) -> Iterator[float | Event]:
        mapped = replace(task, mapping=mapping) if task.source == source else task
        return learn(mapped, stop, wait, to_skip)

    return Engine(kind_of=kind, look=look_mapped, read=read_mapped, learn=learn_mapped)
