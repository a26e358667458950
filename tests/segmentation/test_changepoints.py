"""The search is exact: it agrees with trying every segmentation."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imitate.segmentation.changepoints import most_probable_cuts


def brute_force(score: np.ndarray, expected_length: float, shortest: int) -> float:
    frames, p = score.shape[0], 1 / expected_length
    totals = []
    for count in range(frames):
        for inner in combinations(range(1, frames), count):
            pieces = list(pairwise((0, *inner, frames)))
            if all(b - a >= min(shortest, frames) for a, b in pieces):
                total = sum(score[b - 1, a] for a, b in pieces)
                totals.append(total + len(pieces) * np.log(p) + (frames - len(pieces)) * np.log(1 - p))
    return max(totals)


def value_of(cuts: tuple[int, ...], score: np.ndarray, expected_length: float) -> float:
    p, pieces = 1 / expected_length, list(pairwise(cuts))
    total = sum(score[b - 1, a] for a, b in pieces)
    return float(total + len(pieces) * np.log(p) + (cuts[-1] - len(pieces)) * np.log(1 - p))


@settings(deadline=None, max_examples=60)
@given(
    frames=st.integers(1, 8),
    shortest=st.integers(1, 4),
    expected_length=st.floats(1.1, 200),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_segmentation_is_more_probable(frames, shortest, expected_length, seed):
    score = np.random.default_rng(seed).normal(scale=5, size=(frames, frames))
    rows = (score[end - 1, :end] for end in range(1, frames + 1))
    cuts, best = most_probable_cuts(rows, frames, expected_length, shortest)
    assert best == pytest.approx(brute_force(score, expected_length, shortest))
    assert value_of(cuts, score, expected_length) == pytest.approx(best)
    assert cuts[0] == 0
    assert cuts[-1] == frames
    assert min(np.diff(cuts)) >= min(shortest, frames)


def test_a_mean_that_changes_twice_is_cut_twice():
    rng = np.random.default_rng(1)
    x = rng.normal(scale=0.3, size=90) + np.repeat([0.0, 2.0, -1.0], 30)
    total, square = np.append(0, np.cumsum(x)), np.append(0, np.cumsum(x**2))

    def rows():
        for end in range(1, len(x) + 1):
            n = end - np.arange(end)
            spread = (square[end] - square[:end]) - (total[end] - total[:end]) ** 2 / n
            yield -spread / (2 * 0.3**2) - 2

    cuts, _ = most_probable_cuts(rows(), len(x), 30)
    assert cuts == (0, 30, 60, 90)
