"""Decisions that explain the motion far less well are said so; what is as good is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stacking import Stacking, perform

from imitate.segmentation import apply_decisions, doubts, segment
from imitate.segmentation.doubts import DOUBTFUL, Doubt
from imitate.settings import Segmentation
from imitate.skill import Abstraction, Decision, Segment

ROBUST = Segmentation()
DEMONSTRATION, _ = perform(Stacking(), np.random.default_rng(0))
FOUND = segment(DEMONSTRATION, ROBUST)
GREEN = Abstraction(("hand",), "green")


def after(*decisions: Decision) -> tuple[Segment, ...]:
    return apply_decisions(FOUND, decisions, DEMONSTRATION, ROBUST)


def doubted(*decisions: Decision) -> tuple[Doubt, ...]:
    return doubts(DEMONSTRATION, FOUND, after(*decisions), ROBUST)


def test_what_was_found_is_not_doubted() -> None:
    assert doubted() == ()
    assert doubted(Decision("merge", 0), Decision("undo")) == ()
    assert doubted(Decision("merge", 0), Decision("merge", 0), Decision("reset")) == ()


def test_an_abstraction_is_doubted_by_its_own_rank() -> None:
    (doubt,) = doubted(Decision("relabel", 0, abstraction=GREEN))
    (reach, *_) = FOUND
    likely = {c.abstraction: c.log_likelihood for c in reach.alternatives}
    assert doubt.log_ratio == likely[GREEN] - reach.alternatives[0].log_likelihood < -DOUBTFUL
    assert (doubt.first, doubt.last) == (0, 0)
    assert str(doubt) == (
        f"skill 1: the motion is e^{doubt.log_ratio:.0f} times as likely for ⟨{{hand}}, green⟩ as for "
        "⟨{hand}, blue⟩; kept, as you decided"
    )


def test_a_merge_across_a_change_is_doubted() -> None:
    (doubt,) = doubted(Decision("merge", 0))
    assert (doubt.first, doubt.last) == (0, 0)
    assert doubt.decided == "uncut"
    assert doubt.found == f"cut at {FOUND[0].end:.2f} s"


def test_a_cut_where_nothing_changes_is_doubted() -> None:
    (doubt,) = doubted(Decision("split", 1, time=(FOUND[1].start + FOUND[1].end) / 2))
    assert (doubt.first, doubt.last) == (1, 2)
    assert doubt.found == "uncut"
    assert str(doubt).startswith("skill 2–3: the motion is e^-")


def test_a_boundary_is_doubted_once_it_is_far_from_the_change() -> None:
    near, far = (doubted(Decision("move", 0, time=FOUND[0].end + by)) for by in (-0.05, 1.0))
    assert near == ()
    assert [(d.first, d.last) for d in far] == [(0, 1)]


def test_each_stretch_is_doubted_for_itself() -> None:
    both = doubted(Decision("move", 0, time=FOUND[0].end + 1.0), Decision("relabel", 2, abstraction=GREEN))
    alone = doubted(Decision("move", 0, time=FOUND[0].end + 1.0))
    assert both[:1] == alone
    assert {d.first for d in both[1:]} <= {2}


def test_a_boundary_moved_by_less_than_a_frame_of_the_search_is_the_same() -> None:
    moved = after(Decision("move", 0, time=FOUND[0].end - 0.002))
    assert doubts(DEMONSTRATION, FOUND, moved, ROBUST, limit=0) == ()


@pytest.mark.parametrize("mode", ["robust", "faithful", "cst"])
@given(k=st.integers(0, 1), share=st.floats(0.05, 0.95))
@settings(max_examples=10)
def test_a_doubt_is_never_about_something_better(mode: str, k: int, share: float) -> None:
    chosen = Segmentation(mode=mode)
    time = FOUND[k].start + share * (FOUND[k + 1].end - FOUND[k].start)
    found = doubts(DEMONSTRATION, FOUND, after(Decision("move", k, time=time)), chosen)
    assert all(d.log_ratio < -DOUBTFUL and k <= d.first <= d.last <= k + 1 for d in found)


def test_moving_there_and_back_is_doubted_as_much_in_either_direction() -> None:
    moved = after(Decision("move", 0, time=FOUND[0].end + 1.0))
    (there,) = doubts(DEMONSTRATION, FOUND, moved, ROBUST)
    assert doubts(DEMONSTRATION, moved, FOUND, ROBUST) == ()
    assert there.log_ratio < 0
