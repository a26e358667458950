"""What the robust score says of a segment: who goes along, and what the hand is near to."""

import numpy as np
import pytest

from imitate.demonstration import Demonstration
from imitate.geometry import Array
from imitate.segmentation.robust import RobustScore
from imitate.settings import Segmentation

SETTINGS = Segmentation()
FRAMES = 61
SIZES = np.full((2, 3), 0.04)


def moving(hand: Array, red: Array, blue: Array) -> Demonstration:
    """A demonstration of 3 s from places (F, 3) m along which everything goes evenly."""
    still = np.tile([0.0, 0, 0, 0, 0, 0, 1], (FRAMES, 1))
    share = np.linspace(0, 1, FRAMES)

    def poses(points: Array) -> Array:
        path = still.copy()
        at = np.linspace(0, 1, len(points))
        path[:, :3] = np.column_stack([np.interp(share, at, points[:, axis]) for axis in range(3)])
        return path

    return Demonstration(
        np.linspace(0, 3, FRAMES),
        poses(hand),
        np.stack([poses(red), poses(blue)], axis=1),
        ("red", "blue"),
        SIZES,
    )


RED, BLUE = np.array([[0.0, 0.0, 0.0]]), np.array([[0.4, 0.0, 0.0]])
ACROSS = np.concatenate([RED, BLUE])


def whole(score: RobustScore):
    return score.evidence(np.array([0]), np.array([len(score.times)]))


@pytest.mark.parametrize("hand", [ACROSS, ACROSS[::-1]])
def test_a_free_hand_is_near_to_what_it_leaves_as_to_what_it_comes_to(hand):
    found = whole(RobustScore(moving(hand, RED, BLUE), SETTINGS))
    np.testing.assert_allclose(found.free, 0, atol=1e-9)
    far = SETTINGS.reference_limit * np.expm1(-0.4 / (SETTINGS.reference_length * SETTINGS.reference_limit))
    left, reached = (0, 1) if hand is ACROSS else (1, 0)
    np.testing.assert_allclose(found.holding[0, 0, [left, reached]], [far, 0], atol=1e-9)
    assert found.table == -SETTINGS.reference_limit < far


def test_what_goes_along_is_relevant_for_as_long_as_it_does():
    score = RobustScore(moving(ACROSS, ACROSS, BLUE + np.array([0, 0.3, 0])), SETTINGS)
    last = len(score.times)
    assert score.said.shape == (last, 2)
    found = score.evidence(np.array([0, last // 2]), np.array([last // 2, last]))
    half, late = score.said[: last // 2].sum(axis=0), score.said[last // 2 :].sum(axis=0)
    np.testing.assert_allclose(found.relevance[0, 0], half - SETTINGS.object_penalty)
    np.testing.assert_allclose(found.relevance[1, 1], late - SETTINGS.object_penalty)
    np.testing.assert_allclose(found.relevance[1, 0], half + late - SETTINGS.object_penalty)
    assert found.relevance[1, 0, 0] > 0 > found.relevance[1, 0, 1]


def test_what_is_held_far_from_the_hand_is_near_to_its_reference_by_its_own_place():
    # The hand holds red 15 cm above it, and red comes to where blue is.
    above = np.array([0, 0, 0.15])
    score = RobustScore(moving(ACROSS + above, ACROSS, BLUE), SETTINGS)
    at_hand, at_body = whole(score).holding[0, 0, 1], score.between(0, len(score.times)).holding[0, 0, 1]
    scale = SETTINGS.reference_length * SETTINGS.reference_limit
    assert at_hand == pytest.approx(SETTINGS.reference_limit * np.expm1(-0.15 / scale))
    assert at_body == pytest.approx(0, abs=1e-9)
