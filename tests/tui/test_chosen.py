"""What is the operator's is told apart from what was found."""

from __future__ import annotations

from dataclasses import replace

import scripted

from imitate.tui.chosen import chosen_of

FOUND = scripted.segments()
REACH, CARRY, RETREAT = FOUND


def test_nothing_is_the_operators_at_first() -> None:
    assert [own.by for own in chosen_of(FOUND, FOUND, ())] == ["auto"] * 3


def test_a_moved_boundary_is_the_operators_on_either_side() -> None:
    moved = replace(REACH, end=4.5, human=True), replace(CARRY, start=4.5, human=True), RETREAT
    first, second, third = chosen_of(FOUND, moved, ())
    assert (first.start, first.end, first.abstraction) == (False, True, False)
    assert (second.start, second.end, second.abstraction) == (True, False, False)
    assert third.by == "auto"


def test_an_abstraction_is_the_operators_unless_it_was_found() -> None:
    other = replace(CARRY, abstraction=scripted.REACH, human=True)
    assert chosen_of(FOUND, (REACH, other, RETREAT), ())[1].abstraction
    same = replace(CARRY, human=True)
    (_, again, _) = chosen_of(FOUND, (REACH, same, RETREAT), ())
    assert not again.abstraction
    assert again.by == "you"


def test_merged_skills_are_the_operators_without_a_value_of_his() -> None:
    merged = replace(CARRY, start=REACH.start, human=True)
    own, _ = chosen_of(FOUND, (merged, RETREAT), ())
    assert (own.human, own.start, own.end, own.abstraction) == (True, False, False, False)


def test_what_is_doubted_is_marked() -> None:
    moved = replace(REACH, end=4.5, human=True), replace(CARRY, start=4.5, human=True), RETREAT
    assert [own.by for own in chosen_of(FOUND, moved, {0})] == ["you !", "you", "auto"]
