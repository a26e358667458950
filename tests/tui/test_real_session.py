"""The application on the real engine: the human demonstration, learned in a child process, keys alone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from scripted_app import at, until

from imitate import events
from imitate.formats.session_log import read_session
from imitate.settings import parse_settings
from imitate.tui.app import ImitateApp

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.mark.slow
async def test_a_session_is_learned_stopped_and_valid(tmp_path: Path) -> None:
    source = tmp_path / "human_stack.npz"
    shutil.copy(FIXTURES / "human_stack.npz", source)
    quick = parse_settings({"learning": {"evaluation_starts": 2}})
    app = ImitateApp(source, quick, seed=1, workers=1, root=tmp_path)
    async with app.run_test(size=(80, 24), notifications=True) as pilot:
        await until(pilot, at(app, "review"), 60)
        found = app.state.segments
        await pilot.press("left", "s")
        await until(pilot, lambda: app.state.progress.counts["explore"] > 0, 120)
        await pilot.press("s")
        await until(pilot, lambda: app.state.ended, 120)
        assert [notice.message for notice in app._notifications] == []
    log = tmp_path / "sessions/human_stack-1.mcap"
    assert app.state.log == log
    story = list(read_session(log))
    decided = [event for event in story if isinstance(event, events.Decided)]
    assert [event.decision for event in decided] == list(app.state.decisions)
    assert decided[0].segments[0].end < found[0].end
    recorded = [event for event in story if isinstance(event, events.TrialFinished)]
    assert len(recorded) == sum(app.state.progress.counts.values())
    assert all(event.record is not None and event.record.steps > 0 for event in recorded)


async def test_a_demonstration_is_cut_and_its_boundary_moved_by_the_real_segmentation(tmp_path: Path) -> None:
    app = ImitateApp(FIXTURES / "human_stack.npz", root=tmp_path)
    async with app.run_test(size=(120, 40), notifications=True) as pilot:
        await until(pilot, at(app, "review"), 60)
        assert [str(s.abstraction) for s in app.state.segments] == [
            "⟨{hand}, cubeA⟩",
            "⟨{hand, cubeA}, cubeB⟩",
        ]
        end = app.state.segments[0].end
        await pilot.press("H")
        await until(pilot, lambda: len(app.state.decisions) == 1)
        assert app.state.segments[0].end == pytest.approx(end - 0.1, abs=0.02)
        await pilot.press("u")
        await until(pilot, lambda: len(app.state.decisions) == 2)
        assert app.state.segments == app.state.found


async def test_the_real_preview_says_what_each_file_holds(tmp_path: Path) -> None:
    from imitate.errors import FileError
    from imitate.tui.files import look

    facts = dict(look(FIXTURES / "human_stack.npz").facts)
    assert facts["cubeA"] == "40 × 40 × 40 mm"
    assert facts["duration"] == "13.63 s"
    recording = look(FIXTURES / "stack.mcap")
    assert recording.kind == "recording"
    assert "320 × 240" in dict(recording.facts)["pictures"]
    assert dict(recording.facts)["rate"] == "12 a second"
    assert recording.picture is not None
    assert recording.picture.shape == (240, 320, 3)
    text = tmp_path / "text.mcap"
    text.write_text("hello")
    with pytest.raises(FileError, match=r"text\.mcap"):
        look(text)
