"""Rests next to a carry go to the carry, within bounds."""

import numpy as np
import pytest

from imitate.segmentation.rests import resting, rests_to_carries
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
