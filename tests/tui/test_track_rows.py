"""The rows of Observe: what stands in them, without colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scripted
from hypothesis import given
from hypothesis import strategies as st

from imitate.tui.track_rows import COMING, HEIGHTS, LOST, signs, track_rows


def test_a_body_that_is_lost_for_one_frame_shows_it_in_the_strip() -> None:
    seen = scripted.sighting(lost=(100, 101))
    assert signs(seen, 0, 40).count(LOST) == 1
    assert signs(seen, 0, 40).index(LOST) == 100 * 40 // 361
    assert LOST not in signs(seen, 1, 40)


def test_the_strip_is_lower_where_the_tracker_is_less_sure() -> None:
    strip = signs(scripted.sighting(), 1, 36)  # blue is at 0.3 from frame 200 to 240, else at 0.75
    assert set(strip) == {HEIGHTS[5], HEIGHTS[2]}
    assert strip[20:24] == HEIGHTS[2] * 4
    assert set(signs(scripted.sighting(), 2, 36)) == {HEIGHTS[-1]}


@given(st.integers(1, 361), st.integers(1, 400), st.integers(0, 2))
def test_the_strip_is_filled_as_far_as_it_is_tracked(frames: int, width: int, body: int) -> None:
    strip = signs(scripted.sighting(frames, lost=(10, 20)), body, width)
    assert len(strip) == width
    done = strip.rstrip(COMING)
    assert COMING not in done
    assert abs(len(done) - frames * width / 361) <= 1


@pytest.mark.parametrize("width", [20, 78, 118])
@pytest.mark.parametrize("frame", [0, 65, 200, 360])
def test_no_row_is_wider_than_the_screen(width: int, frame: int) -> None:
    seen = scripted.sighting(lost=(60, 75))
    named = replace(seen.cast, names=("hand", "a very long name", "b"))
    rows = track_rows(replace(seen, cast=named), frame, max(width, 60)).plain.split("\n")
    assert len(rows) == 5
    assert max(map(len, rows)) <= max(width, 60)


def test_what_is_lost_now_and_in_all_is_said_in_words() -> None:
    seen = scripted.sighting(lost=(60, 75))
    rows = track_rows(seen, 65, 100).plain.split("\n")
    assert "✗ lost" in rows[1] and rows[1].endswith("0.50 s")
    assert "75 %" in rows[2] and rows[2].endswith("0.00 s")
    assert rows[4].strip() == "▲ 2.17 s"
    assert rows[4].index("▲") == rows[1].index("▇") + 65 * len(signs_of(rows[1])) // 361
    assert "90 %" in track_rows(seen, 80, 100).plain


def test_a_body_that_could_not_be_followed_is_said_to_be_left_out() -> None:
    seen = scripted.sighting()
    poses, confidence = np.array(seen.poses), np.array(seen.confidence)
    poses[1:, 2], confidence[1:, 2] = np.nan, 0
    gone = replace(seen, poses=poses, confidence=confidence)
    assert "left out" in track_rows(gone, 0, 100, frozenset(["green"])).plain.split("\n")[3]


def signs_of(row: str) -> str:
    """The strip within a row."""
    return "".join(sign for sign in row if sign in HEIGHTS + LOST + COMING)
