"""What trials say of a formulation, counted and in words."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.events import Evidence, Shortfall
from imitate.learning.evidence import failings, in_words, shortfalls, strayed
from imitate.skill import Grasp, Miss, Policy, Term

POLICY = Policy("cubeB", 5.0, np.zeros(7), np.zeros(7), np.zeros((30, 7)), np.zeros(0))


def miss(kind, distance=0.1):
    return Miss("position", f"off by {distance}", "cubeA", distance, 0.2, Grasp(kind, 1.0, 5.0, 0.04))


HAND = Miss("angle", "the hand is turned", "hand", 0.01, 0.4)


def evidence(misses, best=(26.0, 25.0), explored=15):
    failed = sum(map(bool, misses))
    n = len(misses)
    return Evidence(n - failed, n, 0.0, 0.16, explored, best, best, shortfalls(misses), POLICY)


def test_alike_failings_are_counted_together_the_most_frequent_first():
    found = shortfalls([(miss("slipped", 0.1), HAND), (miss("slipped", 0.3),), (miss("open"),), ()])
    assert [(s.body, s.term, s.grasp, s.starts) for s in found] == [
        ("cubeA", "position", "slipped", 2),
        ("hand", "angle", "", 1),
        ("cubeA", "position", "open", 1),
    ]
    assert found[0].distance == 0.2
    assert found[0].words == "off by 0.1"


def test_words_say_how_often_and_whether_the_cost_fell():
    said = in_words(evidence([(miss("open"),)] * 20), 3.0)
    assert said == (
        "0 of 20 starts, 0.00–0.16; the cost stayed at 25 over 15 trials; cubeA was never grasped"
    )
    fell = evidence([(miss("slipped"),)] * 2 + [()] * 2, best=(41.0, 30.0, 32.0), explored=20)
    assert in_words(fell, 3.0) == (
        "2 of 4 starts, 0.00–0.16; the cost fell from 41 to 30 over 20 trials; "
        "cubeA slipped from the grip in 2 of 4"
    )
    alone = evidence([(HAND,)], best=(26.0,), explored=1)
    assert in_words(alone, 3.0) == "0 of 1 starts, 0.00–0.16; cost 26; the hand ends turned too far"


def test_a_hand_that_stayed_open_and_one_that_missed_have_both_never_grasped():
    mixed = evidence([(miss("open"),), (miss("missed"),), (miss("untouched"),), (miss("let go"),)])
    assert failings(mixed) == "cubeA was never grasped in 2 of 4, cubeA was never touched in 1 of 4"


def test_straying_is_told_from_being_carried_elsewhere():
    for kind in ("untouched", "open", "missed", "slipped"):
        assert strayed(evidence([(miss(kind),)] * 3 + [(miss("held"),)]), ("cubeA",))
    for kind in ("held", "let go"):
        assert not strayed(evidence([(miss(kind),)] * 3 + [(miss("open"),)]), ("cubeA",))
    assert not strayed(evidence([(HAND,)]), ("cubeA",))


@given(st.lists(st.lists(st.sampled_from([miss("open"), miss("held"), HAND]), unique=True), min_size=1))
def test_no_start_is_lost_in_counting(trials):
    found = shortfalls(trials)
    assert sum(s.starts for s in found) == sum(map(len, trials))
    assert all(s.starts <= len(trials) for s in found)
    assert list(found) == sorted(found, key=lambda s: -s.starts)


@pytest.mark.parametrize("term", get_args(Term))
def test_every_failing_has_its_words(term):
    one = Shortfall("cubeA", term, "", 1, 0.1, 0.1, "")
    words = failings(replace(evidence([]), shortfalls=(one,), trials=1))
    assert words
    if term == "moving":
        assert words == "cubeA is still moving"
