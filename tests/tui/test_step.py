"""What every step's screen does."""

from __future__ import annotations

from pathlib import Path

from scripted_app import Script, at, scripted_app, until
from textual.widgets import Footer
from textual.widgets._footer import FooterKey


async def test_the_keys_below_are_made_anew_only_where_they_change(tmp_path: Path) -> None:
    app = scripted_app(tmp_path, Script())
    async with app.run_test() as pilot:
        await until(pilot, at(app, "review"))
        await until(pilot, lambda: bool(app.state.changes))
        await pilot.pause(0.2)
        screen = app.step
        assert screen is not None
        keys = list(screen.query_one(Footer).query(FooterKey))
        assert keys
        for _ in range(5):
            screen.redraw()
            await pilot.pause(0.05)
        assert list(screen.query_one(Footer).query(FooterKey)) == keys
        assert "undo" not in {key.description for key in keys}
        await pilot.press("left")
        await until(pilot, lambda: any(key.description == "undo" for key in screen.query(FooterKey)))
