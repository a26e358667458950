"""Review with the keyboard: what is decided, undone, written and refused."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path

import scripted
from scripted_app import at, scripted_app, until
from textual.widgets import DataTable

from imitate.errors import UsageError
from imitate.formats.decisions import read_decisions
from imitate.skill import Decision
from imitate.tui.review import ReviewScreen
from imitate.tui.skill_table import Alternatives, SkillTable
from imitate.tui.timeline import Timeline


async def test_the_boundary_moves_and_the_move_is_undone(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("right", "l", "L", "shift+left", "h")
        await until(pilot, lambda: len(app.state.decisions) == 5)
        frames = [round(d.time * 30) for d in app.state.decisions]
        assert frames == [121, 122, 125, 122, 121]
        assert app.state.segments[0].human
        await pilot.press("u")
        await until(pilot, lambda: app.state.decisions[-1] == Decision("undo"))
        assert round(app.state.segments[0].end * 30) == 122


async def test_what_was_undone_is_done_again_until_something_else_is_decided(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("r")  # nothing to do again yet
        await pilot.press("right", "u")
        await until(pilot, lambda: app.state.redoable == 1)
        await pilot.pause(0.2)
        await pilot.press("r")
        await until(pilot, lambda: round(app.state.segments[0].end * 30) == 121)
        await pilot.press("u")
        await until(pilot, lambda: app.state.redoable == 1)
        await pilot.pause(0.2)
        await pilot.press("ctrl+y")
        await until(pilot, lambda: round(app.state.segments[0].end * 30) == 121)
        await pilot.press("u", "L")
        await until(pilot, lambda: app.state.decisions[-1].kind == "move")
        await pilot.press("r")
    kinds = [d.kind for d in app.state.decisions]
    assert kinds == ["move", "undo", "redo", "undo", "redo", "undo", "move"]


async def test_a_skill_is_split_and_merged_again(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("down", "x")
        await until(pilot, lambda: len(app.state.segments) == 4)
        assert [s.end for s in app.state.segments] == [4.0, 6.0, 8.0, 12.0]
        await pilot.press("m")
        await until(pilot, lambda: len(app.state.segments) == 3)
        await pilot.press("down", "down", "m")  # the last skill with the one before
        await until(pilot, lambda: len(app.state.segments) == 2)
    assert app.state.decisions == (Decision("split", 1, 6.0), Decision("merge", 1), Decision("merge", 1))


def refuse_to_split(*_: object) -> float:
    raise UsageError("too short to be split")


async def test_a_single_skill_cannot_be_merged_and_one_too_short_not_be_split(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    app.engine = replace(app.engine, split_time=refuse_to_split)
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("m", "m")
        await until(pilot, lambda: len(app.state.segments) == 1)
        await pilot.pause(0.2)
        await pilot.press("m", "x")
        await until(pilot, lambda: len(app._notifications) == 1)
        assert [n.message for n in app._notifications] == ["too short to be split"]
    assert len(app.state.decisions) == 2


async def test_how_sure_the_boundaries_are_is_shown_for_the_segments_as_they_are(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, at(app, "review"))
        table = app.screen.query_one("#segments", DataTable)
        await until(pilot, lambda: str(table.get_row_at(1)[-1]) == "7.75–8.50 s")
        await pilot.press("H")
        await until(pilot, lambda: str(table.get_row_at(0)[-1]) == "3.65–4.40 s")
        assert str(table.get_row_at(2)[-1]) == ""
        await pilot.resize_terminal(80, 24)
        await until(pilot, lambda: len(table.columns) == 6)
        (label,) = [s for s in str(app.screen.query_one(Timeline).render()).splitlines() if "▲" in s]
        assert label.strip() == "▲ 3.90 s, 90 %: 3.65–4.40 s"


async def test_weighing_the_boundaries_does_not_block_the_keys(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    weighing = threading.Event()

    def slow(*_: object) -> tuple[tuple[float, float], ...]:
        weighing.wait(20)
        return ((1.0, 2.0), (3.0, 4.0))

    app.engine = app.works._engine = replace(app.engine, changes=slow)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("right", "right", "u")
        await until(pilot, lambda: len(app.state.decisions) == 3)
        assert app.state.changes == ()
        weighing.set()
        await until(pilot, lambda: app.state.changes == ((1.0, 2.0), (3.0, 4.0)))


async def test_decisions_are_written_and_read_back_and_never_overwritten(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("w")  # nothing to write yet
        await pilot.press("right", "u", "x")
        await until(pilot, lambda: len(app.state.decisions) == 3)
        await pilot.pause(0.2)
        await pilot.press("w")
        await until(pilot, lambda: len(app._notifications) == 1)
        await pilot.press("m")
        await until(pilot, lambda: len(app.state.decisions) == 4)
        await pilot.press("w")
        await until(pilot, lambda: len(app._notifications) == 2)
        first, second = (notice.message for notice in app._notifications)
    written = read_decisions(tmp_path / "sessions/stack.decisions.json")
    assert written == app.state.decisions[:3]
    assert read_decisions(tmp_path / "sessions/stack.decisions-2.json") == app.state.decisions
    assert "--decisions sessions/stack.decisions.json" in first
    assert "sessions/stack.decisions-2.json" in second


async def test_another_abstraction_is_chosen_from_the_ranked_ones(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("j", "enter", "down", "enter")
        await until(pilot, lambda: len(app.state.decisions) == 1)
    assert app.state.decisions == (Decision("relabel", 1, abstraction=scripted.REACH),)
    assert app.state.segments[1].abstraction == scripted.REACH


async def test_a_decision_that_is_refused_is_a_notice_and_changes_nothing(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("down", "right")
        await until(pilot, lambda: len(app._notifications) == 1)
        (notice,) = app._notifications
        assert "Merge them instead" in notice.message
    assert app.state.decisions == ()
    assert app.state.segments == scripted.segments()


async def test_whoever_chooses_an_abstraction_keeps_their_place_when_the_screen_is_drawn_anew(
    tmp_path: Path,
) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, lambda: at(app, "review")() and bool(app.state.changes))
        await pilot.press("enter", "down")
        options = app.screen.query_one(Alternatives)
        app.step.draw()
        await pilot.pause()
        assert options.highlighted == 1
        await pilot.press("enter")
        await until(pilot, lambda: len(app.state.decisions) == 1)
    assert app.state.segments[0].abstraction == app.state.found[0].alternatives[1].abstraction


async def test_the_key_after_enter_already_is_for_the_alternatives(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        step = app.step
        assert isinstance(step, ReviewScreen)
        step.action_alternatives()
        assert app.focused is app.screen.query_one(Alternatives)
        app.screen.query_one(Alternatives).action_leave()
        assert app.focused is app.screen.query_one(SkillTable)
