"""The long works: each is a thread that asks the engine and posts what comes of it to the application."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

from textual.app import App
from textual.worker import get_current_worker

from imitate.demonstration import Demonstration
from imitate.errors import in_words
from imitate.events import Event
from imitate.skill import Segment
from imitate.tui import intents
from imitate.tui.again import Check, Checking, Depth, Library, Runs, Trying
from imitate.tui.album import Album, Wanted
from imitate.tui.engine import Engine
from imitate.tui.sighting import Sighting
from imitate.tui.state import State
from imitate.tui.teaching import Resumed, Task

Stop = Callable[[], bool]
"""asked often; once it is true the work ends as soon as it may."""


class Works:
    """Starts them, in threads of the application; one of a group at a time."""

    def __init__(self, app: App[None], engine: Engine, state: State) -> None:
        self._app, self._engine, self._state = app, engine, state
        self._post = app.post_message

    def _start(self, group: str, work: Callable[[Stop], None]) -> None:
        def run() -> None:
            worker = get_current_worker()
            work(lambda: worker.is_cancelled or not self._app.is_running)

        self._app.run_worker(run, group=group, exclusive=True, thread=True, exit_on_error=False)

    def leave(self) -> None:
        """What is being opened is not wanted any more."""
        self._app.workers.cancel_group(self._app, "open")

    def read(self, path: Path) -> None:
        """Open a file of any kind."""
        self._start("open", partial(self._read, path))

    def _read(self, path: Path, _stop: Stop) -> None:
        try:
            kind = self._engine.kind_of(path)
            if kind == "recording":
                self._post(intents.Recording(path))
            elif kind == "session":
                self._post(intents.Recorded(path, tuple(self._engine.recorded(path))))
            else:
                notes: list[str] = []
                demonstration = self._engine.read(path, notes)
                segments = self._engine.cut(demonstration, self._state.settings)
                self._post(intents.Opened(path, kind, demonstration, segments, tuple(notes)))
        except Exception as error:
            self._post(intents.Failed("open", in_words(error)))

    def observe(self, path: Path) -> None:
        """Observe a recording."""
        state = self._state
        task = Task(path, state.settings, state.seed, state.workers, (), path)
        self._start("open", partial(self._observe, task))

    def _observe(self, task: Task, stop: Stop) -> None:
        notes: list[str] = []
        try:
            for seen in self._engine.observe(task, stop):
                if stop():
                    continue
                if isinstance(seen, Sighting):
                    self._post(intents.Sighted(seen))
                elif isinstance(seen, str):
                    notes.append(seen)
                else:
                    segments = self._engine.cut(seen, task.settings)
                    self._post(intents.Opened(task.source, "recording", seen, segments, tuple(notes)))
        except Exception as error:
            self._post(intents.Failed("observe", in_words(error)))

    def learn(self, task: Task | Resumed) -> None:
        """Learn, or go on with a session that was stopped."""
        self._start("learn", partial(self._learn, task))

    def _learn(self, task: Task | Resumed, _stop: Stop) -> None:
        def stop() -> bool:
            return self._state.stopping or not self._app.is_running

        def wait() -> bool:
            return self._state.pausing

        def skip() -> tuple[int, int] | None:
            return self._state.skipping

        try:
            task.log.parent.mkdir(exist_ok=True)
            story: Iterable[float | Event]
            if isinstance(task, Resumed):
                story = self._engine.resume(task, stop, wait, skip)
            else:
                story = self._engine.learn(task, stop, wait, skip)
            for event in story:
                said = intents.Tracked(event) if isinstance(event, float) else intents.Happened(event)
                self._post(said)
        except Exception as error:
            self._post(intents.Failed("learn", in_words(error)))
        self._post(intents.Ended())

    def reproduce(self) -> None:
        """Run the task from the starts that are chosen."""
        state = self._state
        if state.trying.running or not state.whole or state.log is None:
            return
        state.trying = Trying(state.starts, running=True)
        asked = partial(self._engine.reproduce, Runs(state.log, state.starts, state.workers))
        self._start("reproduce", partial(self._follow, "reproduce", state.trying, asked))

    def films(self) -> None:
        """Read the session's trials, once."""
        library, log = self._state.library, self._state.log
        if library.read or library.reading or log is None:
            return
        library.reading = True
        self._start("films", partial(self._follow, "read", library, partial(self._engine.films, log)))

    def weigh(self) -> None:
        """How sure the boundaries are, and what is far less likely than found; once for these segments."""
        state = self._state
        if state.segments is state.weighed or not state.segments or state.demonstration is None:
            return
        state.weighed = state.segments
        self._start("weigh", partial(self._weigh, state.demonstration, state.segments))

    def _weigh(self, shown: Demonstration, segments: tuple[Segment, ...], stop: Stop) -> None:
        state, engine = self._state, self._engine
        settings = state.progress.settings if state.kind == "session" else state.settings
        found, along = state.found, state.along
        if stop():
            return
        try:
            changes = engine.changes(shown, segments, settings) if len(segments) > 1 else ()
            doubts = engine.doubts(shown, found, segments, settings)
            along = along or engine.along(shown, settings)
            self._post(intents.Weighed(segments, changes, doubts, along))
        except Exception as error:
            self._post(intents.Failed("weigh", in_words(error)))

    def pictures(self) -> None:
        """Read the recording's pictures, once; those that a session keeps, of a session."""
        state, album = self._state, self._state.album
        if album.asked or state.source is None or state.kind == "demonstration":
            return
        album.asked = True
        wanted = Wanted(state.source, state.settings.perception)
        self._start(
            "pictures", partial(self._follow, "pictures", album, partial(self._engine.pictures, wanted))
        )

    def verify(self, depth: Depth) -> None:
        """Replay the session."""
        state = self._state
        if state.checking.running or state.log is None:
            return
        state.checking = Checking(depth, running=True)
        asked = partial(self._engine.verify, Check(state.log, depth, state.workers))
        self._start("verify", partial(self._follow, "verify", state.checking, asked))

    def view(self) -> None:
        """Open the session in Rerun's viewer, and make the file for it where there is none."""
        library, log = self._state.library, self._state.log
        if library.viewing or log is None:
            return
        library.viewing = True
        self._start("view", partial(self._view, log, library))

    def _view(self, log: Path, library: Library, stop: Stop) -> None:
        try:
            for path in self._engine.view(log, lambda: library.stopping or stop()):
                self._engine.open_viewer(path)
        except Exception as error:
            self._post(intents.Failed("view", in_words(error)))
        self._post(intents.Viewed(library))

    def _follow(
        self,
        work: str,
        of: Trying | Checking | Library | Album,
        asked: Callable[[Stop], Iterable[Any]],
        stop: Stop,
    ) -> None:
        try:
            for said in asked(lambda: of.stopping or stop()):
                self._post(intents.Said(of, said))
        except Exception as error:
            self._post(intents.Failed(work, in_words(error)))
        self._post(intents.Said(of, None))
