"""Probabilities of cuts are what enumeration says, sum to one, and are sure where the change is sharp."""

from dataclasses import replace
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from cycles import cycles
from hypothesis import given, settings
from hypothesis import strategies as st
from stacking import Stacking, perform

from imitate.segmentation import segment
from imitate.segmentation.abstraction import Evidence, candidates, score_under, total_scores
from imitate.segmentation.changepoints import Lattice
from imitate.segmentation.posteriors import Posterior, boundary_posteriors, cut_probability, posteriors
from imitate.segmentation.segments import lattice_of, score_of
from imitate.settings import Segmentation
from imitate.skill import Segment

ROBUST = Segmentation()
NAMES = ("a", "b")


def random_evidence(frames: int, rng: np.random.Generator, table: float = -np.inf) -> Evidence:
    """Of all segments of a sequence; two objects, whose four abstractions `candidates` lists all."""
    shape = (frames, frames + 1, 2)
    free = -rng.exponential(3, shape)
    return Evidence(rng.normal(scale=3, size=shape), free, free - rng.exponential(2, shape), table)


class Given:
    """A score that is a table of evidence."""

    prior = -1.3
    lead = None

    def __init__(self, evidence: Evidence) -> None:
        self.all = evidence
        self.times = np.arange(len(evidence.free)) / 30

    def evidence(self, starts, ends):
        at = np.ix_(ends - 1, starts)
        fields = [getattr(self.all, name)[at] for name in ("relevance", "free", "holding")]
        return Evidence(*fields, self.all.table)

    def between(self, start, end):
        return self.evidence(np.array([start]), np.array([end]))

    def each(self, start, end):
        """Every abstraction of one segment, with its score."""
        return {c.abstraction: c.log_likelihood for c in candidates(self.between(start, end), NAMES)}


def segmentations(frames: int, least: int = 1):
    for count in range(frames):
        for inner in combinations(range(1, frames), count):
            if all(b - a >= least for a, b in pairwise((0, *inner, frames))):
                yield (0, *inner, frames)


@settings(deadline=None, max_examples=40)
@given(objects=st.integers(1, 2), table=st.sampled_from([-np.inf, -2.0]), seed=st.integers(0, 2**32 - 1))
def test_the_total_is_the_sum_over_all_abstractions(objects, table, seed):
    evidence = random_evidence(1, np.random.default_rng(seed), table)
    one = [getattr(evidence, name)[0, 0, :objects] for name in ("relevance", "free", "holding")]
    every = candidates(Evidence(*one, table), NAMES[:objects])
    expected = np.logaddexp.reduce([c.log_likelihood for c in every])
    assert total_scores(Evidence(*one, table)) == pytest.approx(expected)
    for c in every:
        score = score_under(Evidence(*one, table), c.abstraction, NAMES[:objects])
        assert score == pytest.approx(c.log_likelihood)


@settings(deadline=None, max_examples=30)
@given(
    frames=st.integers(2, 7),
    shortest=st.integers(1, 3),
    table=st.sampled_from([-np.inf, -2.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_cuts_are_as_probable_as_enumeration_says(frames, shortest, table, seed):
    score = Given(random_evidence(frames, np.random.default_rng(seed), table))
    length = 3.0
    least, weights, expected = min(shortest, frames), [], np.zeros(frames + 1)
    for cuts in segmentations(frames, least):
        pieces = list(pairwise(cuts))
        logs = sum(np.logaddexp.reduce(list(score.each(a, b).values())) + score.prior for a, b in pieces)
        weights.append(np.exp(logs + len(pieces) * np.log(1 / length / (1 - 1 / length))))
        expected[list(cuts[1:-1])] += weights[-1]

    def scores(starts, ends):
        return total_scores(score.evidence(starts, ends)) + score.prior

    found = cut_probability(Lattice(scores, frames, length, shortest))
    assert found == pytest.approx(expected / sum(weights), abs=1e-9)


@settings(deadline=None, max_examples=30)
@given(frames=st.integers(4, 9), count=st.integers(2, 3), seed=st.integers(0, 2**32 - 1))
def test_boundaries_are_as_probable_as_enumeration_says(frames, count, seed):
    rng = np.random.default_rng(seed)
    score = Given(random_evidence(frames, rng))
    every = list(score.each(0, 1))
    chosen = [every[k] for k in rng.integers(len(every), size=count)]
    inner = np.sort(rng.choice(np.arange(1, frames), count - 1, replace=False)).tolist()
    cuts = (0, *inner, frames)
    expected = [np.zeros(frames) for _ in inner]
    ranges = [range(a + 1, c) for a, c in zip(cuts, cuts[2:], strict=False)]
    for positions in product(*ranges):
        if all(b > a for a, b in pairwise((0, *positions, frames))):
            pieces = zip(pairwise((0, *positions, frames)), chosen, strict=True)
            weight = np.exp(sum(score.each(a, b)[q] for (a, b), q in pieces))
            for k, at in enumerate(positions):
                expected[k][at] += weight
    segments = [Segment(a / 30, b / 30, q) for (a, b), q in zip(pairwise(cuts), chosen, strict=True)]
    found = boundary_posteriors(score, cuts, segments, NAMES, ROBUST.model_copy(update={"shortest": 0.0}))
    for posterior, weights in zip(found, expected, strict=True):
        frames_of = np.round(posterior.times * 30).astype(int)
        assert posterior.probability == pytest.approx(weights[frames_of] / weights.sum())
        assert posterior.probability.sum() == pytest.approx(1)


@pytest.mark.parametrize("mode", ["robust", "faithful"])
def test_of_a_demonstration(mode):
    settings = ROBUST.model_copy(update={"mode": mode})
    demonstration, (lift, place) = perform(Stacking(noise=0.002), np.random.default_rng(0))
    segments = segment(demonstration, settings)
    found = posteriors(demonstration, segments, settings)
    assert len(found.boundaries) == len(segments) - 1
    assert found.cut.shape == found.times.shape
    assert np.all((found.cut >= 0) & (found.cut <= 1 + 1e-9))
    for posterior, change in zip(found.boundaries, (lift, place), strict=True):
        assert posterior.probability.sum() == pytest.approx(1)
        assert posterior.within(change, 0.5) > 0.9
        low, high = posterior.interval(0.9)
        assert low - 0.5 < change < high + 0.5
        near = np.abs(found.times - posterior.times[np.argmax(posterior.probability)]) < 0.5
        assert found.cut[near].sum() > 0.5


def test_a_fast_change_is_surer_than_a_slow_one():
    spans = []
    for speed in (3.0, 1 / 3):
        demonstration, _ = perform(Stacking(noise=0.004, speed=speed), np.random.default_rng(2))
        found = posteriors(demonstration, segment(demonstration, ROBUST), ROBUST)
        low, high = found.boundaries[0].interval()
        spans.append(high - low)
    assert spans[0] < spans[1] / 2


@settings(deadline=None, max_examples=6)
@given(objects=st.integers(1, 4), noise=st.sampled_from([0.0, 0.004]), seed=st.integers(0, 2**32 - 1))
def test_what_is_left_out_of_the_sums_does_not_matter(objects, noise, seed):
    demonstration = cycles(700, objects, noise, np.random.default_rng(seed))
    lattice = lattice_of(score_of(demonstration, ROBUST), ROBUST, total_scores)
    whole = cut_probability(replace(lattice, lead=None))
    assert cut_probability(lattice) == pytest.approx(whole, abs=1e-6)


def test_one_skill_has_no_boundary():
    demonstration = cycles(20, 2, 0.001, np.random.default_rng(0))
    (only,) = segment(demonstration, ROBUST)
    assert posteriors(demonstration, [only], ROBUST).boundaries == ()


def test_an_interval_leaves_out_as_much_on_either_side():
    posterior = Posterior(np.arange(5.0), np.array([0.04, 0.2, 0.5, 0.22, 0.04]))
    assert posterior.interval(0.9) == (1, 3)
    assert posterior.within(2, 1) == pytest.approx(0.92)
