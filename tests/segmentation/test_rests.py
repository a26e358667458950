"""Rests next to a carry go to the carry, within bounds."""

import numpy as np
import pytest

from imitate.segmentation.rests import let_go, resting, rests_to_carries
from imitate.settings import Segmentation

REST = np.ones(100, bool)
MOVE = np.zeros(100, bool)


@pytest.mark.parametrize(
    ("carries", "rests", "expected"),
    [
        ([False, True, False], REST, (0, 30, 70, 100)),
        ([False, True, False], MOVE, (0, 40, 60, 100)),
        ([False, False, False], REST, (0, 40, 60, 100)),
        ([True, True, True], REST, (0, 40, 60, 100)),
        ([False, True, True], REST, (0, 30, 60, 100)),
    ],
)
def test_only_boundaries_between_a_free_hand_and_a_carry_move(carries, rests, expected):
    assert rests_to_carries((0, 40, 60, 100), carries, rests, most=10, shortest=5) == expected


def test_a_cut_stops_where_the_hand_moves():
    rests = REST.copy()
    rests[36] = False
    assert rests_to_carries((0, 40, 100), [False, True], rests, most=10, shortest=5) == (0, 37, 100)


def test_neighbours_keep_their_shortest_length():
    assert rests_to_carries((0, 8, 92, 100), [False, True, False], REST, 50, 5) == (0, 5, 95, 100)


def test_a_free_hand_between_two_carries_is_not_eaten_from_both_sides():
    cuts = rests_to_carries((0, 40, 52, 100), [True, False, True], REST, 50, 5)
    assert cuts == (0, 47, 52, 100)


def test_resting_is_slow_whatever_the_noise(human_stack):
    settings = Segmentation()
    times = np.array([8.85, 9.7])
    assert resting(human_stack, times, settings).tolist() == [True, False]


def test_a_cut_in_motion_goes_back_to_the_rest_before_it():
    rests = REST.copy()
    rests[37:45] = False
    assert rests_to_carries((0, 40, 100), [False, True], rests, most=10, shortest=5) == (0, 27, 100)
    rests[33:45] = False
    assert rests_to_carries((0, 40, 100), [False, True], rests, most=10, shortest=5) == (0, 40, 100)


@pytest.mark.parametrize("guess", [40, 50, 59])
def test_the_end_of_a_slow_lowering_is_found_in_noise(guess):
    rng = np.random.default_rng(3)
    hand = np.zeros((100, 3))
    hand[:, 2] = np.interp(np.arange(100), [0, 50, 60, 100], [0.05, 0, 0, 0.3])  # 3 cm/s at 30 frames/s
    held = hand.copy()
    held[50:] = 0
    hand, held = (x + rng.normal(scale=0.003, size=x.shape) for x in (hand, held))
    _, end, _ = let_go((0, guess, 100), 1, hand, held[:, None], reach=15, shortest=5)
    # Hand and block rest together from frame 50 to 60; 8 mm is what the noise hides.
    assert 42 <= end <= 62


def test_an_object_is_not_let_go_outside_of_reach():
    hand = np.arange(300.0).reshape(100, 3)
    held = np.minimum(hand, hand[80])
    assert let_go((0, 30, 100), 1, hand, held[:, None], reach=10, shortest=5) == (0, 40, 100)
    assert let_go((0, 3, 6), 1, hand, held[:, None], reach=10, shortest=5) == (0, 3, 6)
