"""The search is exact: it agrees with trying every segmentation, and leaving starts out changes nothing."""

from dataclasses import replace
from itertools import combinations, pairwise, permutations

import numpy as np
import pytest
from cycles import cycles
from hypothesis import given, settings
from hypothesis import strategies as st

from imitate.segmentation.abstraction import Evidence, candidates
from imitate.segmentation.changepoints import Lattice, most_probable_cuts
from imitate.segmentation.segments import lattice_of, score_of
from imitate.settings import Segmentation

ROBUST = Segmentation()


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
    padded = np.pad(score, ((0, 0), (0, 1)))
    lattice = Lattice(
        lambda starts, ends: padded[np.ix_(ends - 1, starts)], frames, expected_length, shortest
    )
    cuts, best = most_probable_cuts(lattice)
    assert best == pytest.approx(brute_force(score, expected_length, shortest))
    assert value_of(cuts, score, expected_length) == pytest.approx(best)
    assert cuts[0] == 0
    assert cuts[-1] == frames
    assert min(np.diff(cuts)) >= min(shortest, frames)


def mean_changes(x: np.ndarray, sigma: float, cost: float) -> Lattice:
    """Segments of constant mean, by least squares."""
    total, square = np.append(0, np.cumsum(x)), np.append(0, np.cumsum(x**2))

    def scores(starts, ends):
        n = np.maximum(ends[:, None] - starts, 1)
        spread = (square[ends][:, None] - square[starts]) - (total[ends][:, None] - total[starts]) ** 2 / n
        return -spread / (2 * sigma**2) - cost

    return Lattice(scores, len(x), 30)


def test_a_mean_that_changes_twice_is_cut_twice():
    rng = np.random.default_rng(1)
    x = rng.normal(scale=0.3, size=90) + np.repeat([0.0, 2.0, -1.0], 30)
    cuts, _ = most_probable_cuts(mean_changes(x, 0.3, 2))
    assert cuts == (0, 30, 60, 90)


def scores_of(demonstration, **changed):
    settings = ROBUST.model_copy(update=changed)
    score = score_of(demonstration, settings)
    return score, lattice_of(score, settings)


@settings(deadline=None, max_examples=25)
@given(
    frames=st.integers(2, 420),
    objects=st.integers(1, 5),
    noise=st.sampled_from([0.0, 0.002, 0.012]),
    penalty=st.sampled_from([0.0, 3.0]),
    shortest=st.floats(0, 1),
    expected=st.floats(0.2, 10),
    seed=st.integers(0, 2**32 - 1),
)
def test_starts_that_are_left_out_change_nothing(frames, objects, noise, penalty, shortest, expected, seed):
    demonstration = cycles(frames, objects, noise, np.random.default_rng(seed))
    _, lattice = scores_of(demonstration, object_penalty=penalty, shortest=shortest, expected_length=expected)
    whole = replace(lattice, lead=None)
    (cuts, best), (_, exact) = most_probable_cuts(lattice), most_probable_cuts(whole)
    assert best == pytest.approx(exact, abs=1e-6)
    worth = sum(lattice.scores(np.array([a]), np.array([b]))[0, 0] + lattice.cost for a, b in pairwise(cuts))
    assert worth + lattice.constant == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("seed", range(4))
def test_of_cuts_worth_the_same_the_latest_are_taken_whatever_is_left_out(seed, noise):
    _, lattice = scores_of(cycles(400, 1 + seed, noise, np.random.default_rng(seed)))
    assert most_probable_cuts(lattice)[0] == most_probable_cuts(replace(lattice, lead=None))[0]


@settings(deadline=None, max_examples=25)
@given(objects=st.integers(1, 4), noise=st.sampled_from([0.0, 0.005]), seed=st.integers(0, 2**32 - 1))
def test_no_start_gains_more_on_another_than_its_lead(objects, noise, seed):
    rng = np.random.default_rng(seed)
    score, _ = scores_of(cycles(200, objects, noise, rng))
    starts, ends = rng.integers(0, 150, 12), np.arange(150, 200)
    evidence, names = score.evidence(starts, ends), [str(k) for k in range(objects)]

    def every(row, column):
        one = [getattr(evidence, name)[row, column] for name in ("relevance", "free", "holding")]
        return {c.abstraction: c.log_likelihood for c in candidates(Evidence(*one, evidence.table), names)}

    lead = score.lead(starts, starts)
    for row in (0, len(ends) - 1):
        scores = [every(row, column) for column in range(len(starts))]
        for i, j in permutations(range(len(starts)), 2):
            shared = scores[i].keys() & scores[j].keys()
            assert shared
            assert max(scores[i][q] - scores[j][q] for q in shared) <= lead[i, j] + 1e-6


def test_a_long_demonstration_keeps_few_starts():
    demonstration = cycles(3000, 4, 0.003, np.random.default_rng(3))
    _, lattice = scores_of(demonstration)
    seen = []

    def counted(starts, ends):
        seen.append(len(starts) - len(ends))
        return lattice.scores(starts, ends)

    cuts, _ = most_probable_cuts(replace(lattice, scores=counted))
    assert len(cuts) > 20
    assert max(seen) < 400
