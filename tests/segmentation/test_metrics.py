"""Agreement of segmentations: counted by hand, and what holds of any two."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.segmentation.metrics import compare
from imitate.skill import Abstraction, Segment

REACH, CARRY = Abstraction(("hand",), "blue"), Abstraction(("hand", "blue"), "green")
RETREAT = Abstraction(("hand",), "green")


def cut(*ends: float, of: tuple[Abstraction, ...] = (REACH, CARRY, RETREAT)) -> tuple[Segment, ...]:
    starts = (0.0, *ends[:-1])
    return tuple(Segment(a, b, of[k % len(of)]) for k, (a, b) in enumerate(zip(starts, ends, strict=True)))


TRUTH = cut(2.0, 5.0, 8.0)


def test_the_same_is_right_throughout():
    m = compare(TRUTH, TRUTH)
    assert (m.precision, m.recall, m.time_share, m.segments_right, m.worst) == (1, 1, 1, m.segments, 0)


def test_a_boundary_is_right_within_the_tolerance():
    found = cut(2.4, 5.6, 8.0)
    m = compare(found, TRUTH, 0.5)
    assert (m.found, m.true, m.matched) == (2, 2, 1)
    assert m.worst == pytest.approx(0.4)
    assert m.time_share == pytest.approx(7 / 8)
    assert compare(found, TRUTH, 0.7).matched == 2


def test_one_boundary_is_not_right_twice():
    m = compare(cut(1.9, 2.1, 5.0, 8.0), TRUTH)
    assert (m.found, m.matched) == (3, 2)
    assert (m.precision, m.recall) == (pytest.approx(2 / 3), 1)


def test_pairs_are_as_many_as_there_can_be():
    assert compare(cut(1.6, 2.4, 8.0), cut(2.0, 2.8, 8.0)).matched == 2


def test_the_order_of_names_does_not_matter_and_the_reference_does():
    same, other = Abstraction(("blue", "hand"), "green"), Abstraction(("hand", "blue"), "red")
    assert compare(cut(8.0, of=(same,)), cut(8.0, of=(CARRY,))).time_share == 1
    assert compare(cut(8.0, of=(other,)), cut(8.0, of=(CARRY,))).segments_right == 0


def test_a_right_segment_counts_by_what_covers_most_of_it():
    m = compare(cut(1.5, 5.0, 8.0, of=(REACH, CARRY, REACH)), TRUTH)
    assert (m.segments_right, m.segments) == (2, 3)


def test_without_boundaries_nothing_is_wrong():
    m = compare(cut(8.0), cut(8.0))
    assert (m.precision, m.recall) == (1, 1)
    assert compare(cut(8.0), TRUTH).recall == 0


ENDS = st.lists(st.floats(0.1, 20), min_size=1, max_size=6, unique=True).map(sorted)


@given(ENDS, ENDS, st.floats(0, 3))
def test_swapping_the_two_swaps_precision_and_recall(a, b, tolerance):
    one, two = compare(cut(*a), cut(*b), tolerance), compare(cut(*b), cut(*a), tolerance)
    assert (one.precision, one.recall) == (two.recall, two.precision)
    assert one.time_share == pytest.approx(two.time_share)
    assert 0 <= one.time_share <= 1 + 1e-9
    assert one.worst <= tolerance
