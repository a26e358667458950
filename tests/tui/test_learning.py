"""Learning in the application: pause, stop, go on, and what is shown meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest
import scripted
from scripted_app import Script, at, scripted_app, until
from textual.widgets import Input, Label, Static

from imitate import events
from imitate.errors import ImitateError
from imitate.tui.attempts import AttemptTable
from imitate.tui.form import FormScreen


async def test_stopping_finishes_the_present_trial_and_keeps_the_rest(tmp_path: Path) -> None:
    script = Script(list(islice(scripted.session(), 12)), hold=True)
    app = scripted_app(tmp_path, script)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.progress.counts["evaluate"] > 0)
        await pilot.press("escape")
        await until(pilot, at(app, "review"))
        await pilot.press("right")  # nothing moves while learning runs
        await pilot.press("s")
        await until(pilot, at(app, "learn"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.ended)
        assert at(app, "learn")()
    assert len(script.tasks) == 1
    assert app.state.decisions == ()
    assert app.state.progress.finished is None
    assert len(app.state.attempts) == 1


async def test_keys_are_answered_while_learning_runs(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, Script(list(islice(scripted.session(), 60)), hold=True))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.screen.query_one(AttemptTable).present == 1)
        await pilot.press("up")
        table = app.screen.query_one(AttemptTable)
        await until(pilot, lambda: table.cursor_row == 0 and not table.following)
        await pilot.press("f")
        await until(pilot, lambda: table.cursor_row == 1 and table.following)


async def test_learning_that_ends_under_a_note_shows_the_result(tmp_path: Path) -> None:
    script = Script(list(scripted.session()), hold=True)
    app = scripted_app(tmp_path, script)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, at(app, "learn"))
        await pilot.press("f1")
        await until(pilot, lambda: app.step is None)
        script.hold = False
        await until(pilot, at(app, "reproduce"))
        await pilot.press("escape")
        await until(pilot, at(app, "learn"))
        await pilot.press("n")
        await until(pilot, at(app, "reproduce"))


@pytest.mark.parametrize(
    ("ending", "message"),
    [
        (
            ImitateError("cubeA stands out of reach. Move it nearer."),
            "cubeA stands out of reach. Move it nearer.",
        ),
        (ZeroDivisionError("division by zero"), "This is a fault of imitate"),
    ],
)
async def test_learning_that_fails_at_once_is_a_notice_and_leads_back_to_review(
    tmp_path: Path, ending: Exception, message: str
) -> None:
    app = scripted_app(tmp_path, Script([], ending=ending))
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: len(app._notifications) == 1)
        await until(pilot, at(app, "review"))
        (notice,) = app._notifications
    assert message in notice.message
    assert app.state.editable


async def test_learning_again_begins_anew_and_never_writes_over_a_session(tmp_path: Path) -> None:
    script = Script(list(scripted.session()))
    app = scripted_app(tmp_path, script)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, at(app, "reproduce"))
        script.tasks[0].log.touch()
        await pilot.press("escape", "escape")
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: len(script.tasks) == 2 and app.state.ended)
    assert [task.log.name for task in script.tasks] == ["stack-3.mcap", "stack-3-2.mcap"]
    assert len(app.state.attempts) == 4


async def test_going_back_to_a_segment_shows_its_new_formulation(tmp_path: Path) -> None:
    story = list(scripted.session())
    learned = [k for k, event in enumerate(story) if isinstance(event, events.OptionLearned)]
    again = replace(story[2].formulation, index=1, reason="the carry failed: learn the reach again")
    app = scripted_app(tmp_path, Script([*story[: learned[1]], events.FormulationStarted(again)], hold=True))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: len(app.state.attempts) == 4)
        table = app.screen.query_one(AttemptTable)
        await until(pilot, lambda: table.row_count == 7)
        assert table.present == 1
        rows = [[str(cell) for cell in table.get_row_at(k)] for k in range(7)]
    assert [row[0] for row in rows] == ["1 ┬", "  ├", "  ├", "  └", "2 ┬", "  └", "3"]
    assert rows[1][-1] == "▸ learning"
    assert rows[2][-1] == "○ next"


async def test_a_pause_holds_the_trials_back_until_it_goes_on(tmp_path: Path) -> None:
    slow = threading.Event()

    def story() -> Iterator[events.Event]:
        yield from islice(scripted.session(), 6)
        slow.wait(20)
        yield from islice(scripted.session(), 6, None)

    app = scripted_app(tmp_path, Script(story()))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.progress.counts["explore"] == 3)
        await pilot.press("p")
        await until(pilot, lambda: app.state.pausing)
        slow.set()
        await pilot.pause(0.2)
        assert app.state.progress.counts["explore"] == 3
        assert "Paused" in str(app.screen.query_one("#banner", Static).render())
        await pilot.press("g")
        await until(pilot, at(app, "reproduce"))
    assert app.state.progress.finished is not None


async def test_a_stopped_session_opens_where_it_stood_and_is_gone_on_with(tmp_path: Path) -> None:
    story = list(scripted.session())
    script = Script(rest=story)
    app = scripted_app(tmp_path, script, "sessions/stack-001.mcap", recorded=story[:30])
    async with app.run_test() as pilot:
        await until(pilot, at(app, "learn"))
        assert "stopped after" in str(app.screen.query_one("#banner", Static).render())
        assert len(app.state.attempts) == 1
        await pilot.press("g")
        await until(pilot, at(app, "reproduce"))
    assert [task.log for task in script.resumed] == [tmp_path / "sessions/stack-001.mcap"]
    assert len(app.state.attempts) == 4
    assert not app.state.resumable


async def test_learning_that_was_stopped_is_gone_on_with(tmp_path: Path) -> None:
    story = list(scripted.session())
    script = Script(story[:12], hold=True, rest=story)
    app = scripted_app(tmp_path, script)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.progress.counts["evaluate"] > 0)
        await pilot.press("s")
        await until(pilot, lambda: app.state.resumable)
        await pilot.press("g")
        await until(pilot, at(app, "reproduce"))
    assert script.resumed[0].log == script.tasks[0].log
    assert app.state.editable


async def test_what_comes_next_is_in_the_tree_until_it_is_tried_or_not_needed(tmp_path: Path) -> None:
    story = list(scripted.session())
    app = scripted_app(tmp_path, Script(story[:12], hold=True))
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: len(app.state.attempts) == 1)
        table = app.screen.query_one(AttemptTable)
        await until(pilot, lambda: table.row_count == 5)
        rows = [[str(cell) for cell in table.get_row_at(k)] for k in range(5)]
        assert [row[0] for row in rows] == ["1 ┬", "  ├", "  └", "2", "3"]
        assert [row[2] for row in rows] == ["pose", "pose+gripper", "pose", "pose", "pose"]
        assert [row[-1] for row in rows[1:]] == [
            "○ next", "○ then", "○ to come", "○ to come",
        ]  # fmt: skip
        await pilot.press("down")
        await until(pilot, lambda: table.cursor_row == 1)
        said = str(app.screen.query_one("#words", Static).render())
        assert "Skill 1, not tried yet" in said
        assert "open and close the gripper" in said


async def test_the_parts_of_the_cost_are_drawn_where_they_are_asked_for(tmp_path: Path) -> None:
    story = list(scripted.session())
    app = scripted_app(tmp_path, Script(story[:12], hold=True))
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.progress.counts["explore"] == 5)

        def key() -> str:
            return str(app.screen.query_one("#key", Label).render())

        await until(pilot, lambda: "● succeeded" in key())
        await pilot.press("2", "4", "1")
        await until(pilot, lambda: key() == "e end  g grip")
        await pilot.press("2", "4")  # one always stays
        await until(pilot, lambda: key() == "g grip")


async def test_settings_are_changed_before_learning(tmp_path: Path) -> None:
    script = Script(list(scripted.session()))
    app = scripted_app(tmp_path, script)
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("e")
        await until(pilot, lambda: isinstance(app.screen, FormScreen))
        app.screen.query_one("#alpha", Input).value = "1.5"
        await pilot.pause()
        assert "1.5 is not from 0.01 to 1" in str(app.screen.query_one("#faults", Static).render())
        await pilot.press("enter")
        assert isinstance(app.screen, FormScreen)
        for name, value in (("alpha", "0.9"), ("trials", "20"), ("starts", "5"), ("seed", "11")):
            app.screen.query_one(f"#{name}", Input).value = value
        await pilot.press("enter")
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, at(app, "reproduce"))
        await pilot.press("escape")
        await until(pilot, at(app, "learn"))
        await pilot.press("r")
        await until(pilot, lambda: len(script.tasks) == 2)
    task = script.tasks[0]
    learning = task.settings.learning
    assert (learning.alpha, learning.updates, learning.evaluation_starts, task.seed) == (0.9, 3, 5, 11)
    assert task.log == tmp_path / "sessions/stack-11.mcap"
    assert script.tasks[1].settings == task.settings


async def test_a_session_that_cannot_be_gone_on_with_stays_as_it_was(tmp_path: Path) -> None:
    ending = ImitateError("stack-001.mcap: is being written by another process. Wait for it.")
    story = list(scripted.session())
    app = scripted_app(tmp_path, Script(ending=ending), "sessions/stack-001.mcap", recorded=story[:30])
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "learn"))
        await pilot.press("g")
        await until(pilot, lambda: len(app._notifications) == 1)
        await until(pilot, lambda: not app.state.running)
        assert at(app, "learn")()
        assert app.state.resumable
        assert len(app.state.attempts) == 1
