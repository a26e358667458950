"""Keys of one's own, commands by name, and help on the focused widget."""

from __future__ import annotations

from pathlib import Path

import pytest
from scripted_app import at, scripted_app, until
from textual.command import CommandPalette

from imitate.errors import FileError, UnknownNameError
from imitate.tui.keys import bindings, read_keys
from imitate.tui.notes import HelpScreen
from imitate.tui.skill_table import Alternatives, SkillTable


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "keys.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_key_has_a_name_of_its_own_and_none_clash() -> None:
    assert {name for name in bindings() if " " in name} == set()
    assert {"app.quit", "learn.stop", "review.undo", "player.play"} <= bindings().keys()


def test_keys_are_read_by_id(tmp_path: Path) -> None:
    text = '[learn]\nstop = "S"\n[app]\nquit = "ctrl+q, f10"\n'
    assert read_keys(written(tmp_path, text)) == {"learn.stop": "S", "app.quit": "ctrl+q, f10"}


def test_two_keys_may_be_exchanged(tmp_path: Path) -> None:
    text = 'learn.stop = "p"\nlearn.pause = "s"\n'
    assert read_keys(written(tmp_path, text)) == {"learn.stop": "p", "learn.pause": "s"}


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ('learn.stp = "S"', UnknownNameError, r"unknown key in .*keys\.toml: 'learn\.stp'.*learn\.stop"),
        ('learn.stop = "strg+s"', FileError, r"learn\.stop: 'strg\+s' is no key.*Expected such as"),
        ("learn.stop = 3", FileError, r"learn\.stop: 3 is no key"),
        ('learn.stop = "p"', FileError, r"learn\.stop: p is the key of learn\.pause there \(pause\)"),
        ('learn.stop = "?"', FileError, r"learn\.stop: \? is the key of app\.help there"),
        ('app.quit = "u"', FileError, r"app\.quit: u is the key of review\.undo there"),
        ('player.play = "v"', FileError, r"player\.play: v is the key of replay\.verify there"),
        ("learn.stop =", FileError, r"keys\.toml: cannot be read \(Invalid value"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, kind: type, message: str) -> None:
    with pytest.raises(kind, match=message):
        read_keys(written(tmp_path, text))


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.toml: no such file of keys"):
        read_keys(tmp_path / "none.toml")


async def test_ones_own_key_does_it_and_ours_no_more(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    app.set_keymap(read_keys(written(tmp_path, 'review.merge = "f7"')))
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("m")
        assert app.state.decisions == ()
        await pilot.press("f7")
        await until(pilot, lambda: len(app.state.decisions) == 1)


async def test_what_can_be_done_now_is_found_by_its_name(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        offered = {command.title: command.help for command in app.get_system_commands(app.screen)}
        assert offered["Learn these skills"] == "s · review.learn"
        assert "Take back the last decision" not in offered  # there is none
        await pilot.press("ctrl+p")
        await until(pilot, lambda: isinstance(app.screen, CommandPalette))
        await pilot.press(*"merge the selected")
        await pilot.pause(0.5)
        await pilot.press("enter", "enter")
        await until(pilot, lambda: len(app.state.decisions) == 1)
    assert app.state.decisions[0].kind == "merge"


async def test_help_is_about_the_focused_widget_too(tmp_path: Path) -> None:
    app = scripted_app(tmp_path)
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await pilot.press("enter")
        await until(pilot, lambda: isinstance(app.focused, Alternatives))
        await pilot.press("f1")
        await until(pilot, lambda: isinstance(app.screen, HelpScreen))
        assert isinstance(app.screen, HelpScreen)
        assert app.screen._about.endswith(Alternatives.HELP)
        await pilot.press("escape", "escape")
        await until(pilot, lambda: isinstance(app.focused, SkillTable))
        assert at(app, "review")()
