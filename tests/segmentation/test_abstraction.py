"""The best abstraction found object by object is the best of all subsets."""

from itertools import chain, combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imitate.segmentation.abstraction import Evidence, best_scores, candidates, log_prior


def all_scores(evidence: Evidence) -> dict[tuple[tuple[int, ...], int], float]:
    objects = evidence.relevance.shape[1]
    subsets = chain.from_iterable(combinations(range(objects), size) for size in range(objects + 1))
    scores = {}
    for relevant in subsets:
        for reference in set(range(objects)) - set(relevant):
            close = evidence.holding if relevant else evidence.free
            score = evidence.relevance[0, list(relevant)].sum() + close[0, reference]
            scores[relevant, reference] = float(score)
    return scores


@st.composite
def evidences(draw):
    objects, seed = draw(st.integers(1, 5)), draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    free = -rng.exponential(3, (1, objects))
    return Evidence(rng.normal(scale=4, size=(1, objects)), free, free - rng.exponential(2, (1, objects)))


@settings(deadline=None)
@given(evidences())
def test_no_subset_is_better(evidence):
    scores = all_scores(evidence)
    assert best_scores(evidence)[0] == pytest.approx(max(scores.values()))
    assert log_prior(evidence.free.shape[1]) == pytest.approx(-np.log(len(scores)))


@settings(deadline=None)
@given(evidences())
def test_candidates_are_ranked_scored_right_and_start_with_the_best(evidence):
    names = [f"object{k}" for k in range(evidence.free.shape[1])]
    scores, ranking = all_scores(evidence), candidates(evidence, names)
    likelihoods = [c.log_likelihood for c in ranking]
    assert likelihoods == sorted(likelihoods, reverse=True)
    assert likelihoods[0] == pytest.approx(max(scores.values()))
    for c in ranking:
        key = tuple(names.index(name) for name in c.abstraction.carried), names.index(c.abstraction.reference)
        assert c.log_likelihood == pytest.approx(scores[key])
    assert len({c.abstraction for c in ranking}) == len(ranking)


def test_two_objects_have_all_four_candidates():
    flat = np.zeros((1, 2))
    found = {str(c.abstraction) for c in candidates(Evidence(flat - 1, flat, flat), ["a", "b"])}
    assert found == {"⟨{hand}, a⟩", "⟨{hand}, b⟩", "⟨{hand, a}, b⟩", "⟨{hand, b}, a⟩"}


def test_many_objects_stay_few_candidates():
    flat = np.zeros((1, 10))
    assert len(candidates(Evidence(flat + 1, flat, flat), [str(k) for k in range(10)])) <= 10 * 20
