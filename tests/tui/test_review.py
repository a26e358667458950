"""Review with the keyboard alone: the time that is looked at, doubts, and what the operator decided."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scripted
from scripted_app import at, drawn, scripted_app, until
from textual.widgets import DataTable, Static

from imitate.skill import Decision
from imitate.tui.app import ImitateApp
from imitate.tui.looking import VIEWS, Looking
from imitate.tui.moment import Moment, unseen
from imitate.tui.picture import Blocks
from imitate.tui.review import ReviewScreen
from imitate.tui.timeline import Timeline
from imitate.tui.traces import Traces

RECORDING = "fixtures/stack.mcap"


def looking(app: ImitateApp) -> Looking:
    return app.screen.query_one(Looking)


def first_line(app: ImitateApp) -> str:
    return str(app.screen.query_one(Timeline).render()).splitlines()[0]


async def test_the_time_that_is_looked_at_moves_by_frame_and_by_second(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, lambda: at(app, "review")() and looking(app).now == 4.0)  # the first boundary
        await pilot.press("full_stop", "full_stop", "comma")
        assert looking(app).now == pytest.approx(4 + 1 / 30)
        await pilot.press("less_than_sign", "less_than_sign", "greater_than_sign")
        assert looking(app).now == pytest.approx(3 + 1 / 30)
        await until(pilot, lambda: "▼ 3.03 s  hand to blue 8." in first_line(app))
        for _ in range(5):
            await pilot.press("less_than_sign")
        assert looking(app).now == 0.0
        for _ in range(14):
            await pilot.press("greater_than_sign")
        await pilot.press("full_stop")
        assert looking(app).now == 12.0
    assert app.state.decisions == ()


async def test_what_is_looked_at_follows_the_boundary_that_keys_move(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("down")
        await until(pilot, lambda: looking(app).now == 8.0)
        await pilot.press("up", "L")
        await until(pilot, lambda: looking(app).now == pytest.approx(4.1))
        await pilot.press("comma", "comma", "enter", "down")  # nothing moves: the look stays
        await pilot.pause(0.2)
        assert looking(app).now == pytest.approx(4.1 - 2 / 30)


async def test_a_boundary_comes_to_where_one_looks_and_a_skill_is_split_there(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("less_than_sign", "b")
        await until(pilot, lambda: len(app.state.decisions) == 1)
        await pilot.press("less_than_sign", "less_than_sign", "X")
        await until(pilot, lambda: len(app.state.decisions) == 2)
        await pilot.press("right_curly_bracket")
        await until(pilot, lambda: len(app.state.decisions) == 3)
    kinds = [(d.kind, d.segment, d.time) for d in app.state.decisions]
    assert kinds == [
        ("move", 0, pytest.approx(3.0)), ("split", 0, pytest.approx(1.0)), ("move", 0, pytest.approx(2.0))
    ]  # fmt: skip


async def test_a_late_redraw_does_not_look_elsewhere(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await drawn(pilot)
        step = app.step
        assert isinstance(step, ReviewScreen)
        looking(app).step(0, -1)
        step.action_here()
        looking(app).step(0, -1)  # before the decision is drawn
        step.redraw()
        assert looking(app).now == pytest.approx(2.0)


async def test_the_demonstration_plays_to_its_end_and_then_from_its_beginning(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        looking(app).go(11.8)
        await pilot.press("space")
        await until(pilot, lambda: looking(app).now == 12.0)
        await until(pilot, lambda: not looking(app).playing)
        await pilot.press("space")
        await until(pilot, lambda: 0 < looking(app).now < 6)
        await pilot.press("space")
        assert not looking(app).playing
        await pilot.press("space", "comma")
        assert not looking(app).playing


async def test_a_click_on_the_timeline_looks_there(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, lambda: at(app, "review")() and bool(app.state.changes))
        await pilot.click(Timeline, offset=(100, 2))
        await until(pilot, lambda: looking(app).now == pytest.approx(10.05, abs=0.1))


async def test_the_views_follow_one_another_where_there_is_not_room_for_all(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))

        def shown() -> tuple[bool, ...]:
            plots = (app.screen.query_one(f"#{id}", Traces) for id in ("distances", "along"))
            parts = (app.screen.query_one(Moment), *plots)
            return tuple(part.display and looking(app).display for part in parts)

        seen = []
        for _ in VIEWS:
            seen.append(shown())
            await pilot.press("v")
            await pilot.pause()
        assert seen == [(True, False, False), (False, True, False), (False, False, True), (False,) * 3]
        assert shown() == seen[0]
        await pilot.resize_terminal(120, 40)
        await until(pilot, lambda: shown() == (True, True, True))
        await pilot.press("v")
        assert looking(app).has_class("scene")


async def test_a_recordings_picture_is_that_of_the_time_looked_at(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source=RECORDING)
    async with app.run_test() as pilot:
        await until(pilot, lambda: at(app, "review")() and len(app.state.album.shots) == 25)
        await pilot.press("comma")
        picture = app.screen.query_one("#picture", Blocks)
        await until(pilot, lambda: picture.display and picture.image.shape == (48, 64, 3))
        assert app.screen.query_one(Moment)._shot is app.state.album.shots[8]
        await pilot.press("greater_than_sign")
        assert app.screen.query_one(Moment)._shot is app.state.album.shots[10]


async def test_a_demonstration_of_poses_has_no_picture(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, lambda: at(app, "review")() and bool(app.state.changes))
        assert not app.screen.query_one("#picture", Blocks).display
        assert not app.state.album.asked


async def test_what_is_far_less_likely_is_said_once_and_stays_marked(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(size=(120, 40), notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        line = app.screen.query_one("#doubts", Static)
        assert not line.display
        await pilot.press("enter", "down", "enter")
        await until(pilot, lambda: len(app._notifications) == 1)
        (notice,) = app._notifications
        assert notice.severity == "warning"
        assert notice.message == (
            "skill 1: the motion is e^-13 times as likely for ⟨{hand, blue}, green⟩ as for ⟨{hand}, blue⟩; "
            "kept, as you decided."
        )
        assert app.state.decisions[0].kind == "relabel"  # it is not forbidden
        table = app.screen.query_one("#segments", DataTable)
        await until(pilot, lambda: str(table.get_row_at(0)[5]) == "you !")
        assert [*map(str, table.get_row_at(0)[3:5])] == ["hand, blue*", "green*"]
        assert line.display
        await pilot.press("H")  # by little
        await until(pilot, lambda: len(app.state.decisions) == 2 and bool(app.state.doubts))
        await pilot.pause(0.2)
        assert len(app._notifications) == 1
        assert str(line.render()).startswith(" ! skill 1: the motion is e^-13")
        await pilot.press("u", "u")
        await until(pilot, lambda: not app.state.doubts and app.state.undoable == 0)
        await until(pilot, lambda: str(table.get_row_at(0)[5]) == "auto")
        assert not line.display


async def test_everything_is_reset_and_the_reset_is_undone(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("R")  # there is nothing to reset
        await pilot.press("right", "x")
        await until(pilot, lambda: len(app.state.segments) == 4)
        await pilot.press("R")
        await until(pilot, lambda: app.state.segments == scripted.segments())
        await pilot.pause(0.2)
        await pilot.press("R", "u")
        await until(pilot, lambda: len(app.state.segments) == 4)
    assert [d.kind for d in app.state.decisions] == ["move", "split", "reset", "undo"]
    assert app.state.undoable == 2


async def test_the_boundary_of_the_operator_is_told_apart(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("right")
        await until(pilot, lambda: len(app.state.decisions) == 1)
        table = app.screen.query_one("#segments", DataTable)
        await until(pilot, lambda: [*map(str, table.get_row_at(0)[1:3])] == ["0.00", "4.03*"])
        bands = str(app.screen.query_one(Timeline).render()).splitlines()[1]
        assert "║" in bands
        assert "│" in bands


async def test_a_look_and_a_reset_do_not_change_a_recorded_session(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source="sessions/stack-001.mcap")
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("escape")
        await until(pilot, at(app, "learn"))
        await pilot.press("escape")
        await until(pilot, at(app, "review"))
        before = looking(app).now
        await pilot.press("full_stop", "b", "X", "R")
        await pilot.pause(0.2)
        assert looking(app).now > before
    assert app.state.decisions == tuple(app.state.progress.decisions)


def test_what_was_not_seen_in_a_frame_is_named() -> None:
    d = scripted.demonstration()
    hand, objects = d.hand.copy(), d.objects.copy()
    hand[5], objects[5:7, 1] = np.nan, np.nan
    lost = replace(d, hand=hand, objects=objects)
    assert [unseen(lost, k) for k in (4, 5, 6)] == [(), ("hand", "green"), ("green",)]


async def test_frames_in_which_a_body_was_not_seen_are_looked_at_without_it(tmp_path: Path) -> None:
    d = scripted.demonstration()
    objects = d.objects.copy()
    objects[100:140, 1] = np.nan
    app = scripted_app(tmp_path)
    app.engine = replace(app.engine, read=lambda _path, _notes: replace(d, objects=objects))
    app.works._engine = app.engine
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("full_stop")
        await until(pilot, lambda: "hand to blue 0.0 cm; not seen: green" in first_line(app))
    assert app.state.decisions == ()


def test_a_reset_is_a_decision_in_words() -> None:
    assert str(Decision("reset")) == "everything as it was found"
