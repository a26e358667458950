"""The Observe step: what is looked at, gone back to, left, and observed anew."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
import scripted
from scripted_app import TRACKED, Script, at, scripted_app, until
from textual.pilot import Pilot
from textual.widgets import Static

from imitate import events
from imitate.demonstration import Demonstration
from imitate.errors import FileError, ImitateError
from imitate.formats import recordings
from imitate.settings import Perception, Settings
from imitate.tui.app import ImitateApp
from imitate.tui.files import first_picture
from imitate.tui.fingers import FingersScreen
from imitate.tui.intents import Wear
from imitate.tui.notes import ConfirmScreen
from imitate.tui.observe import ObserveScreen
from imitate.tui.overlay import Overlay
from imitate.tui.picture import Picture
from imitate.tui.sighting import Sighting
from imitate.tui.teaching import Task
from imitate.tui.track_rows import TrackRows

RECORDING = "fixtures/stack.mcap"
FAILURE = ImitateError("film.mcap: no hand. Wear a red finger on the left.")


def said(app: ImitateApp) -> str:
    return str(app.screen.query_one("#doing", Static).render())


def rows(app: ImitateApp) -> str:
    return str(app.screen.query_one(TrackRows).render())


def observing(app: ImitateApp) -> ObserveScreen:
    screen = app.screen
    assert isinstance(screen, ObserveScreen)
    return screen


async def gone_back(pilot: Pilot[None], app: ImitateApp) -> ObserveScreen:
    """In Observe again, after everything was tracked."""
    await until(pilot, at(app, "review"))
    await pilot.press("escape")
    await until(pilot, at(app, "observe"))
    return observing(app)


async def test_the_newest_frame_is_shown_until_another_is_looked_at(tmp_path: Path) -> None:
    more = threading.Event()

    class Slow(Script):
        def observe(self, _task: Task, should_stop: Callable[[], bool]) -> Iterator[Sighting | Demonstration]:
            yield scripted.sighting(100)
            more.wait(20)
            yield scripted.sighting(200, begin=100)
            while not should_stop():
                threading.Event().wait(0.01)

    app = scripted_app(tmp_path, Slow(), RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, lambda: app.state.sighting is not None)
        assert observing(app).frame == 99
        await pilot.press("left", "h")
        assert observing(app).frame == 97
        more.set()
        await until(pilot, lambda: app.state.observed > 0.5)
        assert observing(app).frame == 97
        await pilot.press("L")
        assert observing(app).frame == 97 + 30
        await pilot.press("shift+right", "shift+right", "shift+right")
        assert observing(app).frame == 199
        await pilot.press("right")
        assert observing(app).frame == 199
        await until(pilot, lambda: "frame 200 of 361" in said(app))


async def test_going_back_shows_what_was_seen(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source=RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        screen = await gone_back(pilot, app)
        await until(pilot, lambda: "Tracked: 361 frames" in said(app))
        assert "Not seen: the hand for 0.50 s." in said(app)
        assert screen.query_one(Overlay).display
        await pilot.press(*["H"] * 20)
        assert screen.frame == 0
        await pilot.press("L", "L", *["l"] * 5)
        assert screen.frame == 65
        await until(pilot, lambda: "✗ lost" in rows(app))
        await pilot.press("n")
        await until(pilot, at(app, "review"))


async def test_what_a_recording_lost_is_said(tmp_path: Path) -> None:
    note = "1 of 361 pictures of /c[d] is left out"
    app = scripted_app(tmp_path, Script(noted=[note]), RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "review"))
        assert any(f"{note}." in notice.message for notice in app._notifications)
        await gone_back(pilot, app)
        await until(pilot, lambda: f"Of the recording: {note}." in " ".join(said(app).split()))


@pytest.mark.parametrize("column", [0, 20, 40])
async def test_a_click_on_the_strip_looks_there(tmp_path: Path, column: int) -> None:
    app = scripted_app(tmp_path, source=RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        screen = await gone_back(pilot, app)
        await until(pilot, lambda: "▲" in rows(app))
        strip = rows(app).split("\n")[2]
        first = strip.index("▆")
        await pilot.click(TrackRows, offset=(first + column, 2))
        await until(pilot, lambda: rows(app).split("\n")[-1].find("▲") == first + column)
        assert screen.frame < 361
        await pilot.click(TrackRows, offset=(1, 2))
        await pilot.pause()
        assert rows(app).split("\n")[-1].find("▲") == first + column


async def test_other_colours_begin_anew(tmp_path: Path) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await gone_back(pilot, app)
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FingersScreen))
        await until(pilot, lambda: app.screen.query_one(Picture).pixel[0] > 0)
        await pilot.press("enter", "right", "enter")
        await until(pilot, lambda: len(script.watches) == 2 and at(app, "review")())
        assert app.state.sighting is not None
        assert len(app.state.sighting) == 361
    assert script.watches[1].settings.perception.left_finger != "red"


@pytest.mark.parametrize(("key", "watched"), [("y", 2), ("n", 1)])
async def test_decisions_are_not_dropped_unasked(tmp_path: Path, key: str, watched: int) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("right")
        await until(pilot, lambda: len(app.state.decisions) == 1)
        await gone_back(pilot, app)
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FingersScreen))
        await pilot.press("enter", "enter")
        await until(pilot, lambda: isinstance(app.screen, ConfirmScreen))
        await pilot.press(key)
        await until(pilot, lambda: len(script.watches) == watched and app.step is not None)
        await until(pilot, at(app, "review" if key == "y" else "observe"))
        assert len(app.state.decisions) == (0 if key == "y" else 1)


async def test_while_it_is_learned_nothing_is_observed_anew(tmp_path: Path) -> None:
    script = Script([next(scripted.session())], hold=True, watched=True)
    app = scripted_app(tmp_path, script, RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.progress.started is not None)
        await pilot.press("escape")
        await gone_back(pilot, app)
        await pilot.press("f")
        app.post_message(Wear("blue", "green"))
        await pilot.pause(0.1)
        assert at(app, "observe")()
        assert len(script.watches) == 1
        assert app.state.running
    assert isinstance(app.state.progress.started, events.SessionStarted)


async def test_one_that_was_left_is_observed_again_from_the_beginning(tmp_path: Path) -> None:
    script = Script(hold=True)
    app = scripted_app(tmp_path, script, RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, lambda: app.state.observed > 0.4)
        await pilot.press("escape")
        await until(pilot, at(app, "load"))
        await pilot.press("n")
        await until(pilot, lambda: at(app, "observe")() and "Left before it was done" in said(app))
        assert observing(app).frame == TRACKED - 1
        script.hold = False
        await pilot.press("r")
        await until(pilot, at(app, "review"))
        assert app.state.sighting is not None
        assert len(app.state.sighting) == 361


async def test_where_it_fails_at_the_end_it_can_be_seen_when_things_were_lost(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, Script(unseen=FAILURE, late=True), RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, lambda: at(app, "observe")() and "no hand" in said(app))
        assert "✗ lost" in rows(app) and "✗✗✗✗✗✗✗✗✗" in rows(app)
        assert "12.03 s" in rows(app)


async def test_before_anything_is_found_the_first_picture_is_shown(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, Script(unseen=FAILURE), RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, lambda: at(app, "observe")() and "no hand" in said(app))
        overlay = observing(app).query_one(Overlay)
        await until(pilot, lambda: overlay.display and overlay.image.shape == (48, 64, 3))
        assert not observing(app).query_one("#bodies").display


def test_a_recording_without_pictures_has_no_first_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def opened(_path: Path, settings: Perception) -> SimpleNamespace:
        asked.append(settings)
        return SimpleNamespace(frames=lambda: iter(()))

    monkeypatch.setattr(recordings, "open_recording", opened)
    with pytest.raises(FileError, match=r"film\.mcap: has no picture .* imitate info"):
        first_picture(tmp_path / "film.mcap", Settings())
    assert asked == [Settings().perception]


async def test_what_was_found_before_is_gone_while_it_is_observed_anew(tmp_path: Path) -> None:
    class Again(Script):
        def observe(self, task: Task, should_stop: Callable[[], bool]) -> Iterator[Sighting | Demonstration]:
            if self.watches:
                self.watches.append(task)
                while not should_stop():
                    threading.Event().wait(0.01)
            else:
                yield from super().observe(task, should_stop)

    script = Again()
    app = scripted_app(tmp_path, script, RECORDING)
    async with app.run_test(size=(80, 24)) as pilot:
        screen = await gone_back(pilot, app)
        await pilot.press(*["H"] * 20)
        app.post_message(Wear("blue", "green"))
        await until(pilot, lambda: len(script.watches) == 2 and app.state.sighting is None)
        await until(pilot, lambda: not screen.query_one("#bodies").display)
        overlay = screen.query_one(Overlay)
        assert overlay.display
        drawn = "".join(segment.text for y in range(overlay.size.height) for segment in overlay.blocks(y))
        assert set(drawn) == {"▀"}
        assert "Finding the table" in said(app)
        assert not app.state.reachable("review")
