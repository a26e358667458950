"""The operator's decisions do what they say, and say so where they cannot."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stacking import RIGHT, Stacking, perform

from imitate.errors import UsageError
from imitate.segmentation import apply_decisions, changes, segment, split_time
from imitate.settings import Segmentation
from imitate.skill import Abstraction, Decision

ROBUST = Segmentation()
DEMONSTRATION, _ = perform(Stacking(), np.random.default_rng(0))
FOUND = segment(DEMONSTRATION, ROBUST)


def after(*decisions: Decision):
    return apply_decisions(FOUND, decisions, DEMONSTRATION, ROBUST)


def test_no_decision_changes_nothing():
    assert after() == FOUND


def test_move_moves_one_boundary_and_keeps_the_abstractions():
    reach, carry, retreat = after(Decision("move", 0, time=1.5))
    assert reach.end == carry.start == 1.5
    assert (reach.abstraction, carry.abstraction) == RIGHT[:2]
    assert reach.human
    assert carry.human
    assert retreat == FOUND[2]
    assert carry.alternatives != FOUND[1].alternatives


def test_relabel_changes_the_abstraction_alone():
    wanted = Abstraction(("hand",), "green")
    _, _, retreat = after(Decision("relabel", 2, abstraction=wanted))
    assert retreat == replace(FOUND[2], abstraction=wanted, human=True)


def test_split_makes_two_of_one():
    segments = after(Decision("split", 1, time=3.0))
    assert len(segments) == 4
    assert segments[1].start == FOUND[1].start
    assert segments[1].end == segments[2].start == 3.0
    assert segments[2].end == FOUND[1].end
    assert segments[1].abstraction == segments[2].abstraction == RIGHT[1]


def test_merge_undoes_split():
    whole = after(Decision("split", 1, time=3.0), Decision("merge", 1))
    assert [replace(s, human=False) for s in whole] == list(FOUND)


@pytest.mark.parametrize("boundary", [0, 1])
def test_where_a_merged_segment_is_best_split_lies_the_change(boundary):
    whole = after(Decision("merge", boundary))
    time = split_time(DEMONSTRATION, whole[boundary], ROBUST)
    low, high = changes(DEMONSTRATION, FOUND, ROBUST)[boundary].interval(0.99)
    assert low <= time <= high
    again = after(Decision("merge", boundary), Decision("split", boundary, time=time))
    assert [s.abstraction for s in again] == [s.abstraction for s in FOUND]


def test_what_is_too_short_is_not_split():
    short = replace(FOUND[0], end=FOUND[0].start + 0.15)
    with pytest.raises(UsageError, match=r"too short to be split; each part must last 0.1 s"):
        split_time(DEMONSTRATION, short, ROBUST)


def test_undo_takes_back_the_last_that_still_holds():
    move, split = Decision("move", 0, time=1.5), Decision("split", 1, time=3.0)
    assert after(move, split, Decision("undo")) == after(move)
    assert after(move, split, Decision("undo"), Decision("undo")) == FOUND
    assert after(move, Decision("undo"), split) == after(split)


def test_redo_takes_back_undo_until_something_else_is_decided():
    move, split, undo, redo = (
        Decision("move", 0, 1.5),
        Decision("split", 1, 3.0),
        Decision("undo"),
        Decision("redo"),
    )
    assert after(move, split, undo, undo, redo) == after(move)
    assert after(move, split, undo, undo, redo, redo) == after(move, split)
    with pytest.raises(UsageError, match=r"decision 4 \(redo\): there is nothing to redo"):
        after(move, undo, split, redo)


def test_reset_leads_back_to_what_was_found_and_can_be_undone():
    move, split = Decision("move", 0, 1.5), Decision("split", 1, 3.0)
    reset, undo, redo = Decision("reset"), Decision("undo"), Decision("redo")
    assert after(move, split, reset) == FOUND
    assert after(move, split, reset, undo) == after(move, split)
    assert after(move, reset, undo, redo) == FOUND
    assert after(move, reset, split) == after(split)
    with pytest.raises(UsageError, match=r"decision 3 \(redo\): there is nothing to redo"):
        after(move, reset, redo)


def test_the_table_may_be_the_reference():
    wanted = Abstraction(("hand", "blue"), "table")
    assert after(Decision("relabel", 1, abstraction=wanted))[1].abstraction == wanted


@pytest.mark.parametrize(
    ("decision", "message"),
    [
        (Decision("undo"), r"decision 1 \(undo\): there is nothing to undo"),
        (Decision("split", 3, time=1.0), "there is no segment 3; segments are numbered 0 to 2"),
        (Decision("split", -1, time=1.0), "there is no segment -1"),
        (Decision("merge", 2), "there are no segments 2 and 3"),
        (Decision("move", 0, time=9.0), r"9 s is outside of 0.10 to \d+\.\d\d s"),
        (Decision("split", 0, time=0.0), "0 s is outside of"),
        (Decision("relabel", 0), "no abstraction is given"),
        (Decision("relabel", 0, abstraction=Abstraction(("hand",), "bleu")), "Did you mean 'blue'"),
        (Decision("relabel", 0, abstraction=Abstraction(("blue",), "green")), "the hand is always relevant"),
        (Decision("relabel", 0, abstraction=Abstraction(("hand", "blue"), "blue")), "cannot be one of"),
        (
            Decision("relabel", 0, abstraction=Abstraction(("hand", "blue", "blue"), "green")),
            "an object is named twice",
        ),
    ],
)
def test_what_cannot_be_done_is_said_in_words(decision, message):
    with pytest.raises(UsageError, match=message):
        after(decision)


def test_the_decision_at_fault_is_named():
    with pytest.raises(UsageError, match=r"^decision 2 \(merge\)"):
        after(Decision("move", 0, time=1.5), Decision("merge", 7))


KINDS = st.sampled_from(["move", "split", "merge", "reset", "undo"])


@settings(deadline=None, max_examples=25)
@given(st.lists(st.tuples(KINDS, st.integers(0, 3), st.floats(0, 6)), max_size=5))
def test_whatever_is_decided_segments_stay_in_order_without_gaps(decided):
    decisions = [Decision(kind, k, time) for kind, k, time in decided]
    try:
        segments = after(*decisions)
    except UsageError:
        return
    assert segments[0].start == FOUND[0].start
    assert segments[-1].end == FOUND[-1].end
    for a, b in pairwise(segments):
        assert a.end == b.start
    assert all(s.end - s.start > 0.09 for s in segments)
