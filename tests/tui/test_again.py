"""What is done with a finished session: new starts, replay, Rerun."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scripted
from hypothesis import given
from hypothesis import strategies as st
from scripted_app import SAME, Script, at, scripted_app, until
from textual.pilot import Pilot
from textual.widgets import Input, Static

from imitate.session.replay import Divergence
from imitate.tui.again import Starts
from imitate.tui.app import ImitateApp
from imitate.tui.films import FilmTable
from imitate.tui.form import FormScreen
from imitate.tui.player import Player
from imitate.tui.starts import edited, fault_of, fields_of
from imitate.tui.words import bar, report_in_words

SESSION = "sessions/stack-001.mcap"
SCENE = scripted.started().scene


def said(app: ImitateApp, name: str) -> str:
    return str(app.screen.query_one(f"#{name}", Static).render())


async def fill(pilot: Pilot[None], app: ImitateApp, name: str, value: str) -> None:
    app.screen.query_one(f"#{name}", Input).value = value
    await pilot.pause()


async def test_the_task_is_run_from_perturbed_starts_and_counted(tmp_path: Path) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, at(app, "reproduce"))
        assert "r runs it from 10 starts moved by up to ±2 cm and ±15°" in said(app, "starts")
        await pilot.press("e")
        await until(pilot, lambda: isinstance(app.screen, FormScreen))
        await fill(pilot, app, "count", "5")
        await fill(pilot, app, "shift", "3.5")
        await pilot.press("enter")
        await until(pilot, at(app, "reproduce"))
        await pilot.press("r")
        await until(pilot, lambda: app.state.trying.result is not None)
        await until(pilot, lambda: "4 of 5 succeeded = 0.80 [0.38, 0.96]" in said(app, "starts"))
        table = app.screen.query_one(FilmTable)
        assert [str(table.get_row_at(k)[1])[0] for k in range(5)] == ["✓", "✗", "✓", "✓", "✓"]
    (runs,) = script.runs
    assert runs.log == tmp_path / SESSION
    assert runs.starts.effective == (5, 0.035, 15.0)


async def test_a_typed_start_is_checked_and_run(tmp_path: Path) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FormScreen))
        assert app.screen.query_one("#object1", Input).value == "20.0 10.0 0"
        await fill(pilot, app, "object0", "20 11")
        await pilot.press("enter")
        assert "is not three numbers: x y turn" in said(app, "faults")
        await fill(pilot, app, "object0", "20 11 0")
        await pilot.press("enter")
        assert "blue and green stand in each other: 1.0 cm" in said(app, "faults")
        await fill(pilot, app, "object0", "5 -10 90")
        await pilot.press("enter")
        await until(pilot, at(app, "reproduce"))
        await pilot.press("r")
        await until(pilot, lambda: app.state.trying.result is not None)
    (runs,) = script.runs
    assert runs.starts.effective == (1, 0.0, 0.0)
    assert runs.starts.poses is not None
    assert runs.starts.poses[0] == pytest.approx([0.05, -0.1, 0.02, 0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    assert runs.starts.poses[1] == pytest.approx(SCENE.object_poses[1])


async def test_leaving_the_form_of_a_first_typed_start_goes_on_to_the_shown_one(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source=SESSION)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FormScreen))
        await pilot.press("escape")
        await until(pilot, lambda: app.state.starts.kind == "shown")


async def test_runs_are_stopped_and_a_task_that_was_not_learned_has_none(tmp_path: Path) -> None:
    script = Script(hold=True)
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("r")
        await until(pilot, lambda: len(app.state.trying.films) == 10)
        await until(pilot, lambda: "to run" in said(app, "starts"))
        await pilot.press("s")
        await until(pilot, lambda: not app.state.trying.running)
        assert app.state.trying.result is None
    story = list(scripted.session())
    app = scripted_app(tmp_path, Script(story[:40], ending=RuntimeError("x")))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.ended)
        await pilot.press("n")
        await until(pilot, at(app, "reproduce"))
        assert "Not every skill was learned: g goes on" in said(app, "starts")
        await pilot.press("r")
        await pilot.pause(0.1)
        assert app.state.trying.asked is None


async def test_a_session_is_verified_at_each_depth(tmp_path: Path) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n")
        await until(pilot, at(app, "replay"))
        for _ in range(3):
            await pilot.press("v")
            await until(pilot, lambda: app.state.checking.report is not None)
            await until(pilot, lambda: "✓ 0 divergent: 79,320 steps of 38 trials" in said(app, "verified"))
            await pilot.press("d")
            app.state.checking.report = None
    assert [check.depth for check in script.checks] == ["physics", "policy", "session"]


async def test_verifying_is_stopped_and_a_divergence_is_said(tmp_path: Path) -> None:
    first = Divergence(17, 1, 0, 3, "hand_poses[0]", 0.25, 0.5)
    script = Script(hold=True, report=replace(SAME, divergent=12, first_divergence=first))
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n")
        await until(pilot, at(app, "replay"))
        await pilot.press("v")
        await until(pilot, lambda: "25 %" in said(app, "verified"))
        await pilot.press("s")
        await until(pilot, lambda: not app.state.checking.running)
        assert app.state.checking.report is None
        script.hold = False
        await pilot.press("v")
        await until(pilot, lambda: "✗ 12 divergent of" in said(app, "verified"))
        assert "First at step 17, trial 3, skill 2: hand_poses[0]" in said(app, "verified")


async def test_a_recorded_trial_is_chosen_scrubbed_and_played(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, source=SESSION)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n")
        await until(pilot, lambda: app.state.library.read and app.screen.query_one(FilmTable).row_count == 6)
        await pilot.press("j")
        player = app.screen.query_one(Player)
        await until(pilot, lambda: player.film is app.state.library.films[1])
        await until(pilot, lambda: "✗ blue ends 61 mm" in said(app, "about"))
        await pilot.press("right", "l", "shift+right", "h", "L")
        assert player.frame == 31
        assert "2.1 of 12.0 s  skill 2, grip open" in said(app, "clock")
        await pilot.press("space")
        await until(pilot, lambda: player.frame > 31)
        await pilot.press("space")
        stood = player.frame
        await pilot.pause(0.3)
        assert player.frame == stood
        player.seek(10_000)
        assert player.frame == player.film.last
        await pilot.press("space")
        await until(pilot, lambda: 0 < player.frame < 30)


async def test_rerun_is_opened_where_there_is_a_display(tmp_path: Path) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, SESSION, display=True)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n", "o")
        await until(pilot, lambda: bool(script.viewed))
    assert script.viewed == [tmp_path / "sessions/stack-001.rrd"]


async def test_without_a_display_it_is_said_what_to_do(tmp_path: Path) -> None:
    script = Script()
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n", "o")
        await until(pilot, lambda: len(app._notifications) == 1)
        (notice,) = app._notifications
    assert "rerun" in notice.message
    assert "stack-001.rrd" in notice.message
    assert script.viewed == []


async def test_another_file_ends_what_is_done_with_the_one_before(tmp_path: Path) -> None:
    script = Script(hold=True)
    app = scripted_app(tmp_path, script, SESSION)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "reproduce"))
        await pilot.press("n", "v")
        await until(pilot, lambda: app.state.checking.share > 0)
        before = app.state.checking
        await pilot.press("ctrl+o")
        await until(pilot, at(app, "load"))
        await pilot.press("down", "down", "enter")
        await until(pilot, at(app, "review"))
        await until(pilot, lambda: not before.running)
        assert app.state.checking.share == 0
        assert not app.state.checking.running


@given(st.floats(-180, 180), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_a_typed_start_is_read_back_as_it_was_typed(turn: float, x: float, y: float) -> None:
    values = {"object0": f"{100 * x:.1f} {100 * y:.1f} {turn:.0f}", "object1": "20 10 0"}
    starts = edited(Starts("typed"), values, SCENE)
    assert starts.poses is not None
    assert np.linalg.norm(starts.poses[:, 3:], axis=1) == pytest.approx(1)
    _, fields = fields_of(starts, SCENE)
    typed, again = ([float(n) for n in text.split()] for text in (values["object0"], fields[0].value))
    assert again[:2] == pytest.approx(typed[:2])
    assert (again[2] - typed[2]) % 360 == pytest.approx(0, abs=1.01) or abs(again[2] - typed[2]) > 358


def test_objects_one_upon_the_other_do_not_stand_in_each_other() -> None:
    stacked = SCENE.object_poses.copy()
    stacked[0, :3] = *stacked[1, :2], 0.07
    scene = replace(SCENE, object_poses=stacked)
    values = {"object0": "20 10 0", "object1": "20 10 0"}
    assert fault_of(values, Starts("typed"), scene) == ""
    assert "stand in each other" in fault_of(values, Starts("typed"), SCENE)


@given(st.floats(-1, 2), st.integers(0, 60))
def test_a_bar_is_as_wide_as_it_should_be(share: float, width: int) -> None:
    assert len(bar(share, width)) == width


def test_damage_is_no_success() -> None:
    good, words = report_in_words(replace(SAME, damage=("cut",)))
    assert not good
    assert "0 divergent" in words
