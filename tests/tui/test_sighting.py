"""What was tracked, as the screen has it: joined from parts, drawn, counted."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scripted
from hypothesis import given
from hypothesis import strategies as st

from imitate.tui.sighting import Sighting
from imitate.tui.words import losses_in_words


@given(st.lists(st.integers(0, 361), max_size=6))
def test_parts_join_to_the_whole(cuts: list[int]) -> None:
    edges = [0, *sorted(cuts), 361]
    parts = [scripted.sighting(b, a, lost=(30, 50)) for a, b in pairwise(edges)]
    joined = parts[0]
    for part in parts[1:]:
        joined = joined.then(part)
    whole = scripted.sighting(lost=(30, 50))
    for name in ("t", "poses", "openings", "confidence"):
        np.testing.assert_array_equal(getattr(joined, name), getattr(whole, name))
    assert joined.pictures == whole.pictures
    assert joined.share == 1


def test_lost_seconds_count_each_frame_until_the_next() -> None:
    seen = scripted.sighting(lost=(30, 45))
    np.testing.assert_allclose(seen.lost_seconds, [0.5, 0, 0])
    stretched = np.array(seen.t)
    stretched[45:] += 2  # two seconds without a frame follow on the last one in which it was lost
    np.testing.assert_allclose(replace(seen, t=stretched).lost_seconds, [2.5, 0, 0])
    last = scripted.sighting(lost=(360, 361))
    np.testing.assert_allclose(last.lost_seconds, [1 / 30, 0, 0])
    np.testing.assert_allclose(scripted.sighting(1).lost_seconds, 0)


def test_outlines_are_around_the_bodies_where_the_camera_shows_them() -> None:
    """The camera looks down from 0.6 m at x = 0.05; depth is 0.6 m less the height."""
    seen = scripted.sighting()
    (ring,) = seen.outlines(0, 2)  # green, 50 mm, at 0.2 0.1 on the table
    far, near = 60 / 0.6, 60 / 0.55
    low, high = [32.5 + far * 0.125, 24.5 - near * 0.125], [32.5 + near * 0.175, 24.5 - far * 0.075]
    np.testing.assert_allclose(ring.min(axis=0) * [64, 48], low, atol=0.01)
    np.testing.assert_allclose(ring.max(axis=0) * [64, 48], high, atol=0.01)
    np.testing.assert_array_equal(ring[0], ring[-1])
    left, right = seen.outlines(0, 0)
    gap = np.linalg.norm((left.mean(axis=0) - right.mean(axis=0)) * [64, 48])
    assert gap == pytest.approx(60 / 0.3 * 0.07, rel=0.15)  # 50 mm open, 20 mm fingers, about 0.3 m away


def test_what_is_not_seen_has_no_outline_and_parts_the_way() -> None:
    seen = scripted.sighting(lost=(60, 75))
    assert seen.outlines(70, 0) == []
    assert [len(part) for part in seen.way(90, 0, 1.2)] == [6, 16]
    assert seen.way(70, 0, 0.1) == []
    assert len(seen.way(90, 1, 1.2)) == 1


def test_behind_the_camera_nothing_is_drawn() -> None:
    seen = scripted.sighting()
    turned = replace(seen.cast, camera_from_table=np.array([0, 0, -0.6, 0, 0, 0, 1.0]))
    assert replace(seen, cast=turned).outlines(0, 1) == []


def test_pictures_are_of_the_last_frame_that_has_one() -> None:
    seen = scripted.sighting(7)
    thin = replace(seen, pictures=tuple(p if k % 3 == 0 else b"" for k, p in enumerate(seen.pictures)))
    assert [thin.pictured(k) for k in (0, 1, 3, 5, 6, 99)] == [0, 0, 3, 3, 6, 6]
    assert thin.picture(3).shape == (48, 64, 3)
    assert replace(seen, pictures=(b"",) * 7).pictured(6) is None


def test_the_frame_at_a_time() -> None:
    seen: Sighting = scripted.sighting()
    assert [seen.at(s) for s in (-1, 0, 1.01, 99)] == [0, 0, 30, 360]


def test_losses_in_words_name_who_was_lost_and_who_is_left_out() -> None:
    shown = scripted.demonstration()
    assert losses_in_words(scripted.sighting(), shown) == ""
    assert losses_in_words(scripted.sighting(lost=(0, 30)), shown) == "Not seen: the hand for 1.00 s."
    without = replace(
        shown, objects=shown.objects[:, :1], object_names=("blue",), object_sizes=shown.object_sizes[:1]
    )
    said = losses_in_words(scripted.sighting(), without)
    assert said == "Left out, as it could not be followed: green."
