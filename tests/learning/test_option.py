"""P is an honest binomial with Wilson's interval."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from imitate.learning.option import Success


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_interval_is_wilsons(counts):
    successes, trials = counts
    reference = binomtest(successes, trials).proportion_ci(0.95, "wilson")
    assert Success(successes, trials).interval == pytest.approx((reference.low, reference.high), abs=1e-9)


def test_nothing_tried_says_nothing():
    assert Success(0, 0).interval == (0.0, 1.0)
    assert Success(0, 0).rate == 0
