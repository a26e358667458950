"""Spare cores: shared out evenly, used while they are there, given back; and outcomes the same without."""

import os
import signal
import time
from concurrent.futures import BrokenExecutor
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.session import sweep as module
from imitate.session.session import Request
from imitate.session.spare import Cores, Sharing
from imitate.settings import load_settings

LONGER = load_settings(
    None,
    {
        "learning": {
            "evaluation_starts": 20,
            "candidates": 0,
            "first_rollouts": 20,
            "updates": 1,
            "formulations": 1,
            "near": 1e-6,
        },
        "world": {"settle_time": 0.1},
    },
)
"""Some forty trials, of which none succeeds."""


def cores(count, sessions=1):
    made = Cores(count)
    for _ in range(sessions):
        made.begin()
    return made


@given(st.integers(1, 12), st.integers(1, 12), st.data())
def test_what_is_spare_is_all_lent_and_no_session_gets_more_than_its_share(count, sessions, data):
    # However they come: one may ask for all that it can get before another asks at all.
    pool, has, asking = cores(count, sessions), [0] * sessions, list(range(sessions))
    while asking:
        k = data.draw(st.sampled_from(asking))
        if pool.borrow(has[k]):
            has[k] += 1
        else:
            asking.remove(k)
    spare = max(0, count - sessions)
    assert sum(has) == spare
    assert max(has) <= -(-spare // sessions)


def test_a_session_that_ends_leaves_its_core_and_those_it_had_borrowed():
    pool = cores(4, 2)
    assert pool.borrow(0)
    assert pool.borrow(0)
    assert not pool.borrow(1)
    pool.give_back(1)
    pool.end()
    assert pool.borrow(1)
    assert pool.borrow(2)
    assert not pool.borrow(3)


def test_a_session_that_is_still_to_come_keeps_its_core():
    pool = cores(2)
    pool.begin()
    assert not pool.borrow(0)


def helped(sharing):
    """Once its helper has started, which takes as long as the machine is busy."""
    deadline = time.monotonic() + 120
    while not sharing._ready and time.monotonic() < deadline:
        time.sleep(0.01)
    assert sharing._ready
    return sharing


def _whose(seconds, k):
    time.sleep(seconds)
    return k, os.getpid()


def _alone(here, k):
    # A task that no helper survives.
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.1)
    return k


def test_a_helper_takes_the_last_and_outcomes_come_in_order():
    with Sharing(cores(2)) as sharing:
        done = list(helped(sharing).map(partial(_whose, 0.05), range(100)))
    assert [k for k, _ in done] == list(range(100))
    whose = [pid == os.getpid() for _, pid in done]
    assert whose == sorted(whose, reverse=True)  # here up to some task, and there from it on
    assert 0 < sum(whose) < 100


def test_where_no_core_is_spare_everything_runs_here():
    with Sharing(cores(1)) as sharing:
        assert {pid for _, pid in sharing.map(partial(_whose, 0.0), range(9))} == {os.getpid()}


def test_nothing_is_run_before_its_outcome_is_asked_for_where_no_core_is_spare():
    ran = []
    with Sharing(cores(1)) as sharing:
        outcomes = sharing.map(ran.append, range(9))
        next(outcomes)
    assert ran == [0]


def test_a_core_left_meanwhile_is_used():
    pool = cores(2, 2)
    with Sharing(pool) as sharing:
        outcomes = sharing.map(partial(_whose, 0.05), range(100))
        assert next(outcomes) == (0, os.getpid())
        pool.end()
        assert next(outcomes) == (1, os.getpid())
        helped(sharing)
        assert {pid for _, pid in outcomes} > {os.getpid()}


def test_a_helper_that_dies_breaks_the_batch_and_its_core_is_given_back():
    pool = cores(2)
    sharing = Sharing(pool)
    assert not pool.borrow(0)
    with pytest.raises(BrokenExecutor):
        list(helped(sharing).map(partial(_alone, os.getpid()), range(100)))
    sharing.shutdown(wait=False, cancel_futures=True)
    assert pool.borrow(0)


def test_a_session_is_the_same_whoever_runs_its_trials(source, tmp_path, monkeypatch):
    class Helped(Sharing):
        def __init__(self, pool):
            super().__init__(pool)
            helped(self)

    logs = []
    for count in (1, 2):
        monkeypatch.setattr(module, "_cores", [cores(count)])
        monkeypatch.setattr(module, "Sharing", Helped if count > 1 else Sharing)
        log = tmp_path / f"{count}.mcap"
        assert not module.run_session(0, Request(source, LONGER, 3, 0, log=log)).error
        logs.append(log.read_bytes())
    assert logs[0] == logs[1]
