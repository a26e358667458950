"""Giving a formulation up for the next one, from the key to the engine."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import scripted
from scripted_app import Script, at, scripted_app, until
from textual.widgets import Static

from imitate import events
from imitate.tui.app import ImitateApp
from imitate.tui.notes import ConfirmScreen


async def test_a_formulation_is_skipped_once_that_is_confirmed(tmp_path: Path) -> None:
    going = threading.Event()
    upto = next(
        k for k, e in enumerate(scripted.session()) if isinstance(e, events.PolicyUpdated) and e.segment == 1
    )

    def story() -> Iterator[events.Event]:
        yield from islice(scripted.session(), upto)
        going.wait(20)
        yield events.Skipped(1, 0, 7)
        yield from islice(scripted.session(), upto, None)

    script = Script(story())
    app = scripted_app(tmp_path, script)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("s")
        await until(pilot, lambda: app.state.skippable and app.state.progress.counts["explore"] > 6)
        await pilot.press("x")
        await until(pilot, lambda: isinstance(app.screen, ConfirmScreen))
        question = str(app.screen.query_one(Static).render())
        assert "Give up formulation 1 of skill 2" in question
        assert "The next one is then tried: ⟨{hand, blue}, green⟩ with pose and gripper." in question
        await pilot.press("n")
        assert script.to_skip() is None
        await pilot.press("x")
        await until(pilot, lambda: isinstance(app.screen, ConfirmScreen))
        await pilot.press("y")
        await until(pilot, lambda: script.to_skip() == (1, 0))
        await until(pilot, lambda: "Giving this formulation up" in str(banner(app).render()))
        assert not app.state.skippable
        going.set()
        await until(pilot, at(app, "reproduce"))
    assert script.to_skip() is None
    assert app.state.attempts[1].converged


def banner(app: ImitateApp) -> Static:
    return app.screen.query_one("#banner", Static)
