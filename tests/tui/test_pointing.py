"""Pointing at the fingers in the first picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scripted_app import Script, at, first_picture, scripted_app, until
from textual.geometry import Size
from textual.widgets import Static

from imitate.errors import ImitateError
from imitate.tui.app import ImitateApp
from imitate.tui.fingers import FingersScreen
from imitate.tui.picture import Picture, fitting

UNSEEN = ImitateError("film.mcap: no hand. Wear a red finger on the left.")


def asked(app: ImitateApp) -> str:
    return str(app.screen.query_one("#ask", Static).render())


async def test_both_fingers_are_pointed_at_and_the_recording_observed_with_them(tmp_path: Path) -> None:
    script = Script(unseen=UNSEEN)
    app = scripted_app(tmp_path, script, "fixtures/stack.mcap")
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, lambda: bool(app.state.unseen) and at(app, "observe")())
        await pilot.pause(0.2)
        assert "no hand. Wear a red finger" in str(app.screen.query_one("#doing", Static).render())
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FingersScreen))
        picture = app.screen.query_one(Picture)
        await until(pilot, lambda: picture.pixel[0] > 0)
        picture.point(11, 35)
        await pilot.pause()
        assert "left finger" in asked(app)
        assert "#dc1e14" in asked(app)
        await pilot.press("enter")
        assert "right finger" in asked(app)
        picture.point(44, 35)
        await pilot.press("enter")
        await until(pilot, at(app, "review"))
    worn = script.watches[1].settings.perception
    left, right = ([int(n) for n in text.split(",")] for text in (worn.left_finger, worn.right_finger))
    assert first_picture(tmp_path)[left[1], left[0]].tolist() == [220, 30, 20]
    assert first_picture(tmp_path)[right[1], right[0]].tolist() == [230, 210, 30]


async def test_leaving_the_picture_leaves_the_colours(tmp_path: Path) -> None:
    script = Script(unseen=UNSEEN)
    app = scripted_app(tmp_path, script, "fixtures/stack.mcap")
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, lambda: bool(app.state.unseen) and at(app, "observe")())
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FingersScreen))
        await pilot.press("escape")
        await until(pilot, at(app, "observe"))
        assert app.state.unseen
        await pilot.press("r")
        await until(pilot, at(app, "review"))
    assert script.watches[0].settings == script.watches[1].settings


@pytest.mark.parametrize(
    ("key", "step"),
    [("right", (1, 0)), ("h", (-1, 0)), ("down", (0, 1)), ("K", (0, -8)), ("shift+right", (8, 0))],
)
async def test_the_cursor_moves_by_keys_and_stays_inside(
    tmp_path: Path, key: str, step: tuple[int, int]
) -> None:
    app = scripted_app(tmp_path, Script(hold=True), "fixtures/stack.mcap")
    async with app.run_test(size=(80, 24)) as pilot:
        await until(pilot, at(app, "observe"))
        await pilot.press("f")
        await until(pilot, lambda: isinstance(app.screen, FingersScreen))
        picture = app.screen.query_one(Picture)
        await until(pilot, lambda: picture.cell[0] > 8)
        column, row = picture.cell
        await pilot.press(key)
        assert picture.cell == (column + step[0], row + step[1])
        for _ in range(20):
            await pilot.press("shift+left", "shift+up")
        assert picture.cell == (0, 0)


@given(
    st.integers(10, 200), st.integers(5, 80), st.sampled_from([(480, 640), (720, 1280), (640, 480), (48, 64)])
)
def test_the_picture_fits_and_keeps_its_shape(columns: int, rows: int, shape: tuple[int, int]) -> None:
    image = np.zeros((*shape, 3), np.uint8)
    c, r = fitting(image, Size(columns, rows))
    assert 1 <= c <= columns
    assert 1 <= r <= rows
    assert abs(2 * r - c * shape[0] / shape[1]) <= 1.01
