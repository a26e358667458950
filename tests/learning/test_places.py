"""What objects are to do follows from the demonstration, and from nothing that learning does."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.demonstration import Demonstration
from imitate.geometry import from_yaw, relative
from imitate.learning.places import asked_for, places
from imitate.settings import Settings
from imitate.skill import Abstraction, Segment

LEARNING = Settings().learning
T = np.linspace(0, 2, 201)


def shown(*motions, noise=0.0, sizes=0.04):
    """A demonstration of 2 s whose objects a, b … move by (shift (3,), yaw) from 0.5 s to 1.5 s."""
    rng = np.random.default_rng(0)
    share = np.clip(T - 0.5, 0, 1)[:, None]
    tracks = []
    for k, (shift, yaw) in enumerate(motions):
        where = np.array([0.3 * k, 0, 0.02]) + share * np.array(shift) + rng.normal(0, noise, (len(T), 3))
        tracks.append(from_yaw(where, share[:, 0] * yaw))
    hand = from_yaw(np.tile([0.0, 0, 0.3], (len(T), 1)), np.zeros(len(T)))
    names = tuple("abc"[: len(motions)])
    size = np.full((len(names), 3), sizes)
    return Demonstration(T, hand, np.stack(tracks, axis=1), names, size)


def carried(*relevant, reference="b"):
    return (Segment(0.0, 2.0, Abstraction(("hand", *relevant), reference)),)


STAYED = ((0, 0, 0), 0.0)
LEFT_ALONE = carried()


def test_what_is_carried_has_its_place_relative_to_its_reference(stacking):
    demonstration, segments = stacking
    place, stays = places(demonstration, segments, LEARNING)
    end = relative(demonstration.objects[-1, 1], demonstration.objects[-1, 0])
    assert (place.name, place.kind, place.reference, place.left) == ("cubeA", "carried", "cubeB", True)
    assert np.allclose(place.pose, end, atol=1e-3)
    assert (place.near, place.near_angle) == (LEARNING.near, np.inf)
    assert (stays.name, stays.kind) == ("cubeB", "still")
    assert asked_for((place, stays)) == {"cubeA", "cubeB"}


def test_what_is_still_carried_at_the_end_may_be_held(stacking):
    demonstration, segments = stacking
    assert not places(demonstration, segments[:1], LEARNING)[0].left


@pytest.mark.parametrize(("lift", "near"), [(0.085, 0.02), (0.033, 0.0165), (0.012, 0.006)])
def test_the_tolerance_is_at_most_half_of_what_was_shown(lift, near):
    place, _ = places(shown(((0, 0, lift), 0), STAYED), carried("a", reference="table"), LEARNING)
    assert place.near == pytest.approx(near)
    assert place.least == pytest.approx(near / 2)


def test_what_was_turned_more_than_moved_is_to_be_turned():
    knob = shown(((0, 0, 0), 1.0), STAYED)
    place, _ = places(knob, carried("a"), LEARNING)
    assert place.near_angle == pytest.approx(np.deg2rad(15))
    assert place.least_angle == pytest.approx(np.deg2rad(7.5))
    little = places(shown(((0, 0, 0), 0.3), STAYED), carried("a"), LEARNING)[0]
    assert little.near_angle == pytest.approx(0.15)
    carry = places(shown(((0.2, 0, 0), 1.0), STAYED), carried("a"), LEARNING)[0]
    assert carry.near_angle == np.inf


def test_a_lid_turns_by_what_its_size_makes_of_it():
    lid = ((0.1, 0, 0.1), 1.4)
    assert places(shown(lid, STAYED, sizes=0.3), carried("a"), LEARNING)[0].near_angle < np.inf
    assert places(shown(lid, STAYED, sizes=0.04), carried("a"), LEARNING)[0].near_angle == np.inf


def test_turning_by_a_right_angle_is_none_of_what_looks_the_same_then():
    cube = shown(((0, 0, 0), np.pi / 2), STAYED)
    alike = LEARNING.model_copy(update={"symmetric": ("a",)})
    assert places(cube, LEFT_ALONE, LEARNING)[0].kind == "moved"
    assert places(cube, LEFT_ALONE, alike)[0].kind == "still"


def test_what_was_moved_and_never_carried_is_to_be_displaced_as_shown():
    nail = shown(((0.3, 0, 0), 0), ((0.05, 0, 0), 0))
    hammer, driven = places(nail, carried("a"), LEARNING)
    assert (hammer.kind, driven.kind, driven.reference) == ("carried", "moved", "")
    assert np.allclose(driven.pose, [0.05, 0, 0, 0, 0, 0, 1])
    pushed = places(shown(((0.04, 0, 0), 0), STAYED), LEFT_ALONE, LEARNING)[0]
    assert (pushed.kind, pushed.near) == ("moved", pytest.approx(0.02))


def test_what_a_carry_knocked_need_not_be_knocked_again():
    knocked = shown(((0.3, 0, 0), 0), ((0.015, 0, 0), 0))
    assert places(knocked, carried("a"), LEARNING)[1].kind == "still"
    alone = shown(STAYED, ((0.015, 0, 0), 0))
    assert places(alone, LEFT_ALONE, LEARNING)[1].kind == "moved"
    did_nothing = carried("a", reference="table")
    assert places(alone, did_nothing, LEARNING)[1].kind == "moved"


def test_what_is_carried_and_brought_back_has_to_have_been_away():
    d = shown(((0, 0, 0.1), 0), STAYED)
    objects = d.objects.copy()
    objects[120:, 0] = objects[0, 0]
    back = replace(d, objects=objects)
    place, _ = places(back, carried("a"), LEARNING)
    assert (place.kind, place.near) == ("carried", LEARNING.near)
    assert place.least == pytest.approx(LEARNING.near)
    assert places(back, LEFT_ALONE, LEARNING)[0].kind == "still"


def test_neither_noise_nor_one_wrong_frame_is_motion():
    noisy = shown(STAYED, STAYED, noise=0.004)
    assert {p.kind for p in places(noisy, carried("a"), LEARNING)} == {"still"}
    clean = shown(STAYED, STAYED)
    objects = clean.objects.copy()
    objects[-1, 0, 0] += 0.26
    objects[100, 1, 0] += 0.26
    wrong = replace(clean, objects=objects)
    assert {p.kind for p in places(wrong, carried("a"), LEARNING)} == {"still"}
