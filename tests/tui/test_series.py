"""Values along a demonstration, and the letters that stand for the objects."""

from __future__ import annotations

import numpy as np
import pytest
import scripted
from hypothesis import given
from hypothesis import strategies as st

from imitate.tui.series import distances, letters


def test_distances_are_the_hands_to_each_object() -> None:
    series = distances(scripted.demonstration())
    assert series.names == ("blue", "green")
    blue, green = series.values
    assert series.t[0] == 0
    assert blue[150] == pytest.approx(0)  # held
    assert green[0] == pytest.approx(100 * np.linalg.norm([0.4, 0.2, 0.275]))


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("blue", "green"), ("b", "g")),
        (("cubeA", "cubeB"), ("A", "B")),
        (("red1", "red2", "red12"), ("1", "2", "3")),
        (("cube", "cube2"), ("1", "2")),
        (("milk",), ("m",)),
    ],
)
def test_letters_tell_the_objects_apart(names: tuple[str, ...], expected: tuple[str, ...]) -> None:
    assert letters(names) == expected


@given(st.lists(st.text(min_size=1), min_size=1, max_size=12, unique=True))
def test_there_is_one_letter_for_each(names: list[str]) -> None:
    found = letters(names)
    assert len(found) == len(set(found)) == len(names)
    assert all(found)
