"""Work on what was shown, in a child process: a recording observed, a session learned or gone on with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imitate.events import TrialFinished
from imitate.settings import Settings
from imitate.skill import Decision

if TYPE_CHECKING:
    from imitate.formats.mapping import Mapping
    from imitate.tui.child import Asked, Place

Emit = Callable[[Any], None]
Stop = Callable[[], bool]
Skip = Callable[[], "Place | None"]
"""which formulation is to be given up."""


@dataclass(frozen=True)
class Task:
    """What is to be learned from what.

    Attributes:
        source: a demonstration or a recording.
        log: the session's file.
        mapping: what the source's columns, topics or frames mean.
    """

    source: Path
    settings: Settings
    seed: int
    workers: int
    decisions: tuple[Decision, ...]
    log: Path
    mapping: Mapping | None = None


@dataclass(frozen=True)
class Resumed:
    """Which session is gone on with, in how many processes."""

    log: Path
    workers: int


def observe(task: Task, emit: Emit, should_stop: Stop) -> None:
    """Emits a `Sighting` of the tracked frames, some at a time, each note, then the `Demonstration`."""
    from imitate.demonstration import in_table_frame
    from imitate.formats.recordings import open_recording
    from imitate.perception.observe import Moment
    from imitate.perception.observe import observe as observe_recording
    from imitate.tui.watcher import Watcher

    watcher = Watcher(task.settings.perception, emit)

    def watch(moment: Moment) -> None:
        if should_stop():
            raise SystemExit(0)
        watcher(moment)

    recording = open_recording(task.source, task.settings.perception)
    try:
        found = observe_recording(recording, task.settings, task.seed, watch=watch)
    finally:
        watcher.end()
    for note in recording.notes:
        emit(note)
    emit(in_table_frame(found.demonstration))


def learn(task: Task, emit: Emit, asked: Asked) -> None:
    """Emits, of a recording, shares that were tracked, then the session's events."""
    from imitate.session.session import Request, run

    def watching(done: int, of: int) -> None:
        if asked():
            raise SystemExit(0)
        emit(done / of)

    viewed = task.log.with_suffix(".rrd")
    request = Request(
        task.source,
        task.settings,
        task.seed,
        task.workers,
        task.decisions,
        mapping=task.mapping,
        log=task.log,
        rrd=viewed,
    )
    for event in run(request, asked, watching, asked.skips):
        emit(replace(event, record=None) if isinstance(event, TrialFinished) else event)


def resume(task: Resumed, emit: Emit, asked: Asked) -> None:
    """Emits all events of the session, those recorded first."""
    from imitate.learning.trials import executors
    from imitate.session.resume import Resumption
    from imitate.session.resume import resume as go_on

    resumption = Resumption(task.log, executors(task.workers), rrd=task.log.with_suffix(".rrd"))
    for event in go_on(resumption, asked, asked.skips):
        emit(replace(event, record=None) if isinstance(event, TrialFinished) else event)
