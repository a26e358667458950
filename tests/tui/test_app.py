"""The application with the keyboard alone: what is asked of the engine, and what state results."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest
import scripted
from scripted_app import Script, at, scripted_app, until

from imitate import events
from imitate.tui.attempts import AttemptTable
from imitate.tui.road import Road
from imitate.tui.step import StepScreen

SIZES = [(80, 24), (120, 40)]


@pytest.mark.parametrize("size", SIZES)
async def test_from_a_file_to_the_result_with_keys_alone(tmp_path: Path, size: tuple[int, int]) -> None:
    script = Script(list(scripted.session()))
    app = scripted_app(tmp_path, script, source=None)
    async with app.run_test(size=size) as pilot:
        await until(pilot, at(app, "load"))
        await pilot.press("down", "down", "enter")
        await until(pilot, at(app, "review"))
        await pilot.press("right", "s")
        await until(pilot, at(app, "reproduce"))
    (task,) = script.tasks
    assert task.source == tmp_path / "fixtures/stack.npz"
    assert task.log == tmp_path / "sessions/stack-3.mcap"
    assert task.seed == 3
    assert [d.kind for d in task.decisions] == ["move"]
    assert app.state.progress.finished == events.SessionFinished(True, "")


async def test_every_event_of_a_burst_is_folded(tmp_path: Path) -> None:
    start, cuts, stated, *_ = scripted.session()
    burst = [scripted.trial(0, 0, n, "explore", 0, 30.0, "it fell") for n in range(3000)]
    app = scripted_app(tmp_path, Script([start, cuts, stated, *burst]))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.ended)
    assert app.state.progress.counts["explore"] == 3000


async def test_drawing_is_coalesced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    start, cuts, stated, *_ = scripted.session()
    burst = [scripted.trial(0, 0, n, "explore", 0, 30.0, "it fell") for n in range(2000)]
    app = scripted_app(tmp_path, Script([start, cuts, stated, *burst], hold=True))
    drawn = []
    show = AttemptTable.show
    monkeypatch.setattr(AttemptTable, "show", lambda self, state: (drawn.append(1), show(self, state)))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.progress.counts["explore"] == 2000)
    assert len(drawn) < 100


@pytest.mark.parametrize("key", ["q", "ctrl+q"])
async def test_quitting_asks_only_while_learning(tmp_path: Path, key: str) -> None:
    script = Script(list(islice(scripted.session(), 12)), hold=True)
    app = scripted_app(tmp_path, script)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, at(app, "learn"))
        await pilot.press(key)
        await until(pilot, lambda: not isinstance(app.screen, StepScreen))
        await pilot.press("enter")  # no
        await until(pilot, at(app, "learn"))
        assert not app.state.stopping
        await pilot.press("q", "y")
        await until(pilot, lambda: not app.is_running)
        await until(pilot, lambda: script.stopped)


async def test_quitting_without_learning_does_not_ask(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("q")
        await until(pilot, lambda: not app.is_running)


async def test_a_file_that_cannot_be_opened_is_a_notice(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source="fixtures/broken.mcap")
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, lambda: len(app._notifications) == 1)
        (notice,) = app._notifications
        assert "Record it again." in notice.message
        assert at(app, "load")()


async def test_a_recorded_session_opens_at_its_result_and_cannot_be_changed(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source="sessions/stack-001.mcap")
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("escape")
        await until(pilot, at(app, "learn"))
        assert app.screen.query_one(AttemptTable).row_count == 4
        await pilot.press("escape")
        await until(pilot, at(app, "review"))
        await pilot.press("right", "u", "s")
        await pilot.pause(0.1)
        assert at(app, "review")()
    assert app.state.decisions == ()


async def test_a_recording_is_observed_and_then_reviewed(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source="fixtures/stack.mcap")
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        await until(pilot, lambda: len(app._notifications) == 1)
        (notice,) = app._notifications
    assert app.state.kind == "recording"
    assert notice.message == "Not seen: the hand for 0.50 s. Observe (Esc) shows when."


async def test_observing_is_left_with_escape(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, Script(hold=True), source="fixtures/stack.mcap")
    async with app.run_test() as pilot:
        await until(pilot, lambda: app.state.observed > 0.4)
        assert at(app, "observe")()
        await pilot.press("escape")
        await until(pilot, at(app, "load"))
        await until(pilot, lambda: not any(worker.group == "open" for worker in app.workers))
    assert app.state.demonstration is None


async def test_another_file_after_the_result(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, Script(list(scripted.session())))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("right", "s")
        await until(pilot, at(app, "reproduce"))
        await pilot.press("ctrl+o")
        await until(pilot, at(app, "load"))
        await pilot.press("down", "down", "enter")
        await until(pilot, at(app, "review"))
        await until(pilot, lambda: app.state.decisions == ())
        assert not app.state.ended


async def test_a_click_on_the_road_leads_to_a_step_that_has_something_to_show(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "review"))
        road = app.screen.query_one(Road)
        text = str(road.render())
        await pilot.click(Road, offset=(text.index("Learn"), 0))
        await pilot.pause(0.1)
        assert at(app, "review")()
        await pilot.click(Road, offset=(text.index("Load"), 0))
        await until(pilot, at(app, "load"))
        await pilot.press("n")
        await until(pilot, at(app, "review"))
        assert app.state.demonstration is not None
