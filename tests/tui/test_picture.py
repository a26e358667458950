"""The README's pictures: one of each step, of the recording and the session that lie in the repository."""

from __future__ import annotations

import importlib.util
import shutil
import time
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from scripted_app import Script, at, drawn, scripted_app, until
from textual.pilot import Pilot

from imitate import events
from imitate.events import Reproduced
from imitate.formats.session_log import read_session
from imitate.settings import Perception
from imitate.tui.again import Runs, Starts
from imitate.tui.app import ImitateApp
from imitate.tui.engine import Engine
from imitate.tui.film import Film
from imitate.tui.films import FilmTable
from imitate.tui.photo import photo_of_terminal
from imitate.tui.player import PlayerScreen
from imitate.tui.repeat import read_films, run_starts
from imitate.tui.sighting import Sighting
from imitate.tui.teaching import Task

REPOSITORY = Path(__file__).parents[2]
FILES = ("fixtures/stack.mcap", "fixtures/human_stack.npz", "sessions/stack.mcap")
SESSION = REPOSITORY / "sessions" / "stack.mcap"
SIZE, LARGE = (100, 30), (120, 40)
Compare = Callable[..., bool]

pytestmark = pytest.mark.skipif(not SESSION.exists(), reason="sessions/stack.mcap is not there")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The repository's own files in a folder where nothing else is."""
    for name in FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(REPOSITORY / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TEXTUAL_ANIMATIONS", "none")
    return tmp_path


@cache
def recorded_films() -> tuple[Film, ...]:
    """Every trial of the session."""
    found: list[Film] = []
    read_films(SESSION, found.append, lambda: False)
    return tuple(found)


def run_here(runs: Runs, _stop: Callable[[], bool]) -> Iterator[Film | Reproduced]:
    """The task from new starts, in this process."""
    found: list[Film | Reproduced] = []
    run_starts(replace(runs, log=SESSION, workers=0), found.append, lambda: False)
    yield from found


class Enough(Exception):
    """As many frames as were wanted are tracked."""


def tracked(path: Path, frames: int) -> list[Sighting]:
    """The first frames of a recording, tracked in this process."""
    from imitate.perception.observe import Moment, observe
    from imitate.tui.watcher import Watcher

    found: list[Sighting] = []
    watcher = Watcher(Perception(), found.append, count().__next__)

    def watch(moment: Moment) -> None:
        watcher(moment)
        if len(found) == frames:
            raise Enough

    with pytest.raises(Enough):
        observe(path, watch=watch)
    return found


def application(folder: Path, source: str | None, **others: Any) -> ImitateApp:
    """The real application; trials are read and run in this process, as ``others`` of its works may be."""
    engine = replace(Engine(), films=lambda *_: iter(recorded_films()), reproduce=run_here, **others)
    path = folder / source if source else None
    app = ImitateApp(path, engine=engine, root=folder, photo=photo_of_terminal())
    app.animation_level = "none"
    return app


def first_reformulated_and_learned() -> list[events.Event]:
    """The session until the first skill whose problem was stated anew is learned."""
    restated: set[int] = set()
    story: list[events.Event] = []
    for event in read_session(SESSION, steps=False):
        story.append(event)
        if isinstance(event, events.Reformulated):
            restated.add(event.segment)
        if isinstance(event, events.Evaluated) and event.accepted and event.segment in restated:
            story.pop()
            break
    return story


def pictured(
    compare: Compare,
    app: ImitateApp,
    run: Callable[[Pilot[Any]], Awaitable[None]],
    size: tuple[int, int] = SIZE,
) -> bool:
    async def before(pilot: Pilot[Any]) -> None:
        await run(pilot)
        await until(pilot, lambda: not app._changed)
        app.clear_notifications()  # they go by the clock
        await drawn(pilot)

    return compare(app, terminal_size=size, run_before=before)


def test_load(snap_compare: Compare, folder: Path) -> None:
    app = application(folder, None)

    async def run(pilot: Pilot[Any]) -> None:
        await until(pilot, at(app, "load"))
        await pilot.press("down")
        await until(pilot, lambda: getattr(app.screen.preview, "picture", None) is not None)  # type: ignore[attr-defined]
        await until(pilot, lambda: len(app.screen.query_one("DirectoryTree").root.children) == 2)  # type: ignore[attr-defined]

    assert pictured(snap_compare, app, run)


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("open3d") is None, reason="open3d is not installed")
def test_observing(snap_compare: Compare, folder: Path) -> None:
    def watch(task: Task, should_stop: Callable[[], bool]) -> Iterator[Sighting]:
        yield from tracked(task.source, 110)
        while not should_stop():
            time.sleep(0.01)

    app = application(folder, "fixtures/stack.mcap", observe=watch)

    async def run(pilot: Pilot[Any]) -> None:
        await until(pilot, lambda: app.state.sighting is not None and len(app.state.sighting) == 110, 120)

    assert pictured(snap_compare, app, run)


def test_reviewing(snap_compare: Compare, folder: Path) -> None:
    app = application(folder, "sessions/stack.mcap")

    async def run(pilot: Pilot[Any]) -> None:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("escape")
        await until(pilot, at(app, "learn"))
        await pilot.press("escape")
        await until(pilot, at(app, "review"))
        await pilot.press("down")
        await until(pilot, lambda: len(app.state.changes) == len(app.state.segments) - 1)

    assert pictured(snap_compare, app, run, LARGE)


def test_learning(snap_compare: Compare, folder: Path) -> None:
    story = first_reformulated_and_learned()
    app = scripted_app(folder, Script(story, hold=True, watched=True), "fixtures/stack.mcap")

    async def run(pilot: Pilot[Any]) -> None:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        trials = sum(isinstance(event, events.TrialFinished) for event in story)
        await until(pilot, lambda: sum(app.state.progress.counts.values()) == trials)

    assert pictured(snap_compare, app, run, LARGE)


@pytest.mark.slow
def test_reproducing(snap_compare: Compare, folder: Path) -> None:
    app = application(folder, "sessions/stack.mcap")

    async def run(pilot: Pilot[Any]) -> None:
        await until(pilot, at(app, "reproduce"))
        app.state.starts = Starts(count=3)
        await pilot.press("r")
        await until(pilot, lambda: app.state.trying.result is not None)
        await seek(pilot, app, 10.0)

    assert pictured(snap_compare, app, run)


@pytest.mark.slow
def test_replaying(snap_compare: Compare, folder: Path) -> None:
    app = application(folder, "sessions/stack.mcap")

    async def run(pilot: Pilot[Any]) -> None:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n")
        await until(pilot, lambda: app.state.library.read and at(app, "replay")())
        table = app.screen.query_one(FilmTable)
        await until(pilot, lambda: table.row_count == len(recorded_films()))
        grasped = next(k for k, film in enumerate(recorded_films()) if film.success and film.force.max() > 0)
        table.move_cursor(row=grasped, animate=False)
        await until(pilot, lambda: app.screen.query_one(FilmTable).cursor_row == grasped)
        await drawn(pilot)
        film = recorded_films()[grasped]
        await seek(pilot, app, float(film.t[film.force > 0][0]) + 2)

    assert pictured(snap_compare, app, run)


async def seek(pilot: Pilot[Any], app: ImitateApp, seconds: float) -> None:
    """Scrub to a moment of the trial that is shown."""
    screen = app.screen
    assert isinstance(screen, PlayerScreen)
    await until(pilot, lambda: screen.player.film is not None and screen.player.film.last > 0)
    film = screen.player.film
    assert film is not None
    screen.player.seek(int((film.t < seconds).sum()))
