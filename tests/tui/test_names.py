"""Names that other people chose are shown as they are: in no step are they taken for markup."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import pytest
import scripted
from scripted_app import Script, at, scripted_app, until
from textual.app import App
from textual.pilot import Pilot
from textual.widgets import Label, OptionList, Static

NAMES = {"blue": "[/]a", "green": "cube[left]"}


def renamed(value: Any) -> Any:
    """The same with other names for the blocks, in every text that is in it."""
    if isinstance(value, str):
        for old, new in NAMES.items():
            value = value.replace(old, new)
        return value
    if isinstance(value, tuple):
        return tuple(map(renamed, value))
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: renamed(getattr(value, f.name)) for f in fields(value) if f.init})
    return value


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Script:
    """A session with blocks of those names."""
    story = [renamed(event) for event in scripted.session(reproduced=False)]
    for name in ("demonstration", "segments", "film", "sighting"):
        made = getattr(scripted, name)
        monkeypatch.setattr(scripted, name, lambda *given, made=made, **more: renamed(made(*given, **more)))
    return Script(story)


def text_of(app: App[None]) -> str:
    """All that is on the screen."""
    return "\n".join(strip.text for strip in app.screen._compositor.render_strips())


def check_plain(app: App[None]) -> None:
    """No widget of ours takes what it is given for markup."""
    for widget in app.screen.query(Static):
        if type(widget) in (Static, Label) or type(widget).__module__.startswith("imitate."):
            assert not widget._render_markup, widget
    for choices in app.screen.query(OptionList):
        assert not choices._markup, choices


async def shown(pilot: Pilot[None], app: App[None], step: str, *names: str) -> None:
    """Wait until a step shows these names."""
    await until(pilot, at(app, step))  # type: ignore[arg-type]
    await until(pilot, lambda: all(name in text_of(app) for name in names))
    check_plain(app)


async def test_every_step_shows_names_with_brackets_whole(tmp_path: Path, script: Script) -> None:
    odd = tmp_path / "fixtures/[red]x[].npz"
    odd.parent.mkdir()
    odd.touch()
    app = scripted_app(tmp_path, script, source=None)
    async with app.run_test(size=(120, 40)) as pilot:
        await shown(pilot, app, "load", "[red]x[].npz", "[/]a", "cube[left]")
        await pilot.press("enter")
        await shown(pilot, app, "review", "hand, [/]a", "cube[left]", "⟨{hand}, [/]a⟩")
        await pilot.press("a", "down", "enter")  # another abstraction, which is doubted
        await shown(pilot, app, "review", "skill 1: the motion is", "for ⟨{hand, [/]a}, cube[left]⟩")
        await pilot.press("s")
        await until(pilot, at(app, "reproduce"))
        await pilot.press("r")
        await until(pilot, lambda: len(app.state.trying.films) > 5)
        await pilot.press(*["up"] * 20, "down")
        await shown(pilot, app, "reproduce", "[/]a ends 61 mm", "cube[left]")
        await pilot.press("escape")
        await shown(pilot, app, "learn", "hand, [/]a", "cube[left]")
        await pilot.press("n", "n")
        await until(pilot, at(app, "replay"))
        await until(pilot, lambda: len(app.state.library.films) > 1)
        await pilot.press("down")
        await shown(pilot, app, "replay", "[/]a ends 61 mm")


async def test_observing_shows_them_too(tmp_path: Path, script: Script) -> None:
    script.hold = True
    app = scripted_app(tmp_path, script, source="fixtures/stack.mcap")
    async with app.run_test(size=(120, 40)) as pilot:
        await shown(pilot, app, "observe", "[/]a", "cube[left]")


async def test_errors_and_notices_are_plain_text(tmp_path: Path, script: Script) -> None:
    app = scripted_app(tmp_path, script)
    async with app.run_test(notifications=True) as pilot:
        await until(pilot, at(app, "review"))
        app.notice("[/]a: cube[left] is out of reach")
        await until(pilot, lambda: "[/]a: cube[left]" in text_of(app))
