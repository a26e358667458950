"""A free hand that rests on an object has reached it; what it passes or holds next is no visit."""

import numpy as np
from showing import UP, Camera, Move, Shown, film, placed

from imitate.segmentation import rankings, segment
from imitate.segmentation.visits import visited, visits, with_visits
from imitate.settings import load_settings

ROBUST = load_settings().segmentation
RED, BLUE, HOME = np.array([0.2, 0.1, 0.025]), np.array([-0.2, 0.1, 0.025]), np.array([0.0, -0.3, 0.3])
NAMES = ("red", "blue")


def shown(*moves):
    objects = placed(red=RED, blue=BLUE)
    return film(Shown(objects, moves, (), HOME), Camera(), np.random.default_rng(0))


def reach(point, rest):
    return Move(1.0, point + UP), Move(0.6, point), Move(rest), Move(0.6, point + UP)


def found(demonstration):
    return [str(s.abstraction) for s in segment(demonstration, ROBUST)]


def test_each_object_that_is_touched_is_reached():
    twice = shown(*reach(RED, 0.5), *reach(BLUE, 0.5), *reach(RED, 0.5))
    assert found(twice) == ["⟨{hand}, red⟩", "⟨{hand}, blue⟩", "⟨{hand}, red⟩"]


def test_what_is_touched_names_the_reach_though_the_hand_leaves_it():
    assert found(shown(*reach(RED, 0.5), Move(1.5, BLUE + 2 * UP))) == ["⟨{hand}, red⟩"]


def test_the_reach_ends_where_the_hand_leaves():
    first, _ = segment(shown(*reach(RED, 1.0), *reach(BLUE, 1.0)), ROBUST)
    assert 2.5 < first.end < 2.9


def test_flying_by_and_hovering_are_no_visits():
    above = RED + np.array([0, 0, 0.06])
    assert found(shown(Move(1.0, above), Move(1.0), *reach(BLUE, 0.5))) == ["⟨{hand}, blue⟩"]
    before, after = RED - np.array([0.1, 0, 0]), RED + np.array([0.1, 0, 0])
    assert found(shown(Move(0.5, before), Move(0.5, after), *reach(BLUE, 0.5))) == ["⟨{hand}, blue⟩"]


def test_of_an_object_without_a_size_nothing_is_touched():
    demonstration = shown(*reach(RED, 0.5), *reach(BLUE, 0.5))
    unknown = type(demonstration)(
        demonstration.t, demonstration.hand, demonstration.objects, NAMES, np.full((2, 3), np.nan)
    )
    times = np.arange(0, 6, 1 / 30)
    assert len(visits(demonstration, times, ROBUST)) == 2
    assert len(visits(unknown, times, ROBUST)) == 0


def test_a_visit_into_a_carry_is_its_grasp_and_one_under_way_no_arrival():
    seen = [(0, 9, 0), (20, 30, 0), (50, 60, 1)]
    assert visited(seen, 0, 60) == (1,)
    assert visited(seen, 0, 59) == (0,)
    assert visited(seen, 0, 19) == ()
    assert with_visits((0, 60, 90), [(), ("blue",)], seen, NAMES) == (0, 30, 60, 90)
    assert with_visits((0, 60, 90), [(), ("red",)], seen[:2], NAMES) == (0, 60, 90)
    assert with_visits((0, 60, 90), [("red",), ()], seen, NAMES) == (0, 60, 90)


def test_a_segment_ranked_again_still_names_what_is_visited():
    demonstration = shown(*reach(RED, 0.5), *reach(BLUE, 0.5))
    segments = segment(demonstration, ROBUST)
    again = rankings(demonstration, ROBUST, [*(s.start for s in segments), segments[-1].end])
    assert [ranking[0].abstraction for ranking in again] == [s.abstraction for s in segments]
