"""Judging a policy: it stops where its outcome is certain, and decides what it would have decided."""

from itertools import count

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from test_improve import Pretended

from imitate.learning.runs import Runs
from imitate.settings import load_settings


@pytest.fixture(scope="session")
def judge(short_demonstration, carry_problem):
    """Judges the imitated policy, trials failing by their number."""

    def run(fails, last, **learning):
        number = count()
        settings = load_settings(None, {"learning": learning})
        trials = Pretended(short_demonstration, settings, lambda _: 0.2 * fails(next(number)))
        course = Runs(carry_problem, (), trials, np.random.SeedSequence(0)).judge(
            (carry_problem.imitated,), last=last
        )
        while True:
            try:
                next(course)
            except StopIteration as end:
                return end.value

    return run


@pytest.mark.parametrize(
    ("fails", "last", "successes", "trials", "stopped"),
    [
        (lambda _: True, True, 0, 5, "α is out of reach"),
        (lambda _: True, False, 0, 5, "α is out of reach"),
        (lambda n: n % 2 == 0, False, 4, 9, "α is out of reach"),
        (lambda n: n in (0, 1, 2, 3, 19), False, 15, 20, ""),
        (lambda _: False, True, 16, 16, "α is reached"),
        (lambda n: n in (3, 9, 15), True, 16, 19, "α is reached"),
        (lambda _: False, False, 19, 19, "α is reached for sure"),
        (lambda n: n == 3, False, 19, 20, ""),
        (lambda n: n in (3, 9, 15), False, 17, 20, ""),
    ],
)
def test_judging_stops_where_its_outcome_is_certain(judge, fails, last, successes, trials, stopped):
    learned, whole = judge(fails, last), judge(fails, last, curtail=False)
    assert (learned.success.successes, learned.success.trials, learned.stopped) == (
        successes,
        trials,
        stopped,
    )
    assert (whole.success.trials, whole.stopped) == (20, "")
    assert learned.accepted == whole.accepted
    sure = [made.firm >= 0.9 and made.fair >= 0.95 for made in (learned, whole)]
    assert sure[0] == sure[1] or not learned.accepted


@hypothesis_settings(max_examples=10)
@given(st.sets(st.integers(0, 4)), st.booleans())
def test_stopping_early_decides_nothing_else(judge, failing, last):
    learned, whole = (
        judge(failing.__contains__, last, curtail=curtail, evaluation_starts=5) for curtail in (True, False)
    )
    assert learned.accepted == whole.accepted == (len(failing) <= 1)


def test_a_share_that_is_just_reached_is_not_out_of_reach(judge):
    # 0.56 · 25 is a little more than 14 in floating point.
    just = {"alpha": 0.56, "evaluation_starts": 25}
    learned, whole = (judge(lambda n: n < 11, True, curtail=curtail, **just) for curtail in (True, False))
    assert (learned.success.successes, learned.accepted, whole.accepted) == (14, True, True)
