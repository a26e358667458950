"""The application with the keyboard alone: what is asked of the engine, and what state results."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest
import scripted
from scripted_app import Script, at, scripted_app, until
from textual.widgets import DataTable, Input, Label, Static

from imitate import events
from imitate.errors import ImitateError, UsageError
from imitate.formats.decisions import read_decisions
from imitate.skill import Decision
from imitate.tui.attempts import AttemptTable
from imitate.tui.form import FormScreen
from imitate.tui.road import Road
from imitate.tui.step import StepScreen
from imitate.tui.timeline import Timeline

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


def refuse_to_split(*_: object) -> float:
    raise UsageError("too short to be split")


async def test_how_sure_the_boundaries_are_is_shown_for_the_segments_as_they_are(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test(size=(120, 40)) as pilot:
        await until(pilot, at(app, "review"))
        table = app.screen.query_one("#segments", DataTable)
        await until(pilot, lambda: table.get_row_at(1)[-1] == "7.75–8.50 s")
        await pilot.press("H")
        await until(pilot, lambda: table.get_row_at(0)[-1] == "3.65–4.40 s")
        assert table.get_row_at(2)[-1] == ""
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


async def test_quitting_without_learning_does_not_ask(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("q")
        await until(pilot, lambda: not app.is_running)


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
        rows = [table.get_row_at(k) for k in range(7)]
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
        rows = [table.get_row_at(k) for k in range(5)]
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
