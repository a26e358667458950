"""P is an honest binomial with Wilson's interval."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

from imitate.learning.option import Success


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_interval_is_wilsons(counts):
    successes, trials = counts
    reference = binomtest(successes, trials).proportion_ci(0.95, "wilson")
    assert Success(successes, trials).interval == pytest.approx((reference.low, reference.high), abs=1e-9)


def test_nothing_tried_says_nothing():
    assert Success(0, 0).interval == (0.0, 1.0)
    assert Success(0, 0).rate == 0


def coverage(trials: int, p: float) -> float:
    """How often the interval of ``trials`` holds p: summed over all outcomes, which no simulation betters."""
    intervals = [Success(k, trials).interval for k in range(trials + 1)]
    holds = [low <= p <= high for low, high in intervals]
    return float(binom.pmf(np.arange(trials + 1), trials, p) @ holds)


@pytest.mark.parametrize("p", [0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9])
@pytest.mark.parametrize("trials", [20, 50, 100])
def test_the_interval_holds_the_truth_about_as_often_as_it_says(trials, p):
    assert coverage(trials, p) >= 0.93


@pytest.mark.parametrize("trials", [5, 10, 20, 50, 100])
def test_over_all_truths_it_holds_95_of_100(trials):
    held = np.mean([coverage(trials, p) for p in np.linspace(0.005, 0.995, 199)])
    assert held == pytest.approx(0.95, abs=0.01)


@given(st.integers(1, 300))
def test_its_ends_are_exact(trials):
    none, all_of_them = Success(0, trials), Success(trials, trials)
    assert (none.rate, none.interval[0]) == (0.0, 0.0)
    assert (all_of_them.rate, all_of_them.interval[1]) == (1.0, 1.0)
    assert 0 < none.interval[1] < 1
    assert 0 < all_of_them.interval[0] < 1


@given(st.integers(1, 100))
def test_more_successes_of_as_many_raise_both_ends(trials):
    ends = np.array([Success(k, trials).interval for k in range(trials + 1)])
    assert np.all(np.diff(ends, axis=0) > 0)


@given(st.integers(1, 40), st.integers(2, 10), st.data())
def test_more_trials_with_the_same_rate_narrow_it(trials, times, data):
    successes = data.draw(st.integers(0, trials))
    few, many = Success(successes, trials).interval, Success(times * successes, times * trials).interval
    assert many[1] - many[0] < few[1] - few[0]
