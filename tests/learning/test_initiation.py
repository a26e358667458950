"""The initiation set: what is foretold, and how honest its precision and recall are."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from records import moved, still

from imitate.geometry import compose, from_yaw, relative
from imitate.learning.initiation import initiation_set, probability, seen_from, start_of
from imitate.settings import Settings
from imitate.skill import Abstraction

LEARNING = Settings().learning
CARRY = Abstraction(("hand", "cubeA"), "cubeB")
REACH = Abstraction(("hand",), "cubeA")


def starts(count, seed=0, in_hand=0.001):
    """The hand and the block in it moved by ±2 cm and ±15° together, the block in the hand by a little."""
    rng = np.random.default_rng(seed)
    hands = from_yaw(
        np.column_stack([rng.uniform(-0.02, 0.02, (count, 2)), np.full(count, 0.1)]),
        np.deg2rad(rng.uniform(-15, 15, count)),
    )
    held = from_yaw(rng.normal(0, in_hand, (count, 3)), np.zeros(count))
    return np.stack([hands, compose(hands, held)], axis=1)


def learned(where, ok):
    return initiation_set(CARRY, where, np.asarray(ok, float), LEARNING)


@pytest.mark.parametrize("seed", range(5))
def test_starts_like_those_that_succeeded_are_in_and_far_ones_are_not(seed):
    tried = learned(starts(26, seed), np.ones(26))
    inside = [probability(tried, s) >= tried.threshold for s in starts(100, seed + 100)]
    assert np.mean(inside) >= 0.95
    far = starts(20, seed)
    far[..., 0] += 0.2
    assert all(probability(tried, s) < 0.1 for s in far)
    turned = compose(from_yaw(np.zeros(3), np.pi / 2), starts(20, seed))
    assert all(probability(tried, s) < 0.1 for s in turned)


def test_a_block_out_of_its_place_in_the_hand_is_noticed():
    tried = learned(starts(26), np.ones(26))
    odd = starts(1, seed=9, in_hand=0.0)[0]
    assert probability(tried, odd) > 0.8
    odd[1, 0] += 0.015  # less than hand and block together move from start to start
    assert probability(tried, odd) < 0.5


@pytest.mark.parametrize("seed", range(3))
def test_where_failures_gather_they_are_foretold(seed):
    where = starts(60, seed)
    ok = where[:, 0, 0] < 0.008
    tried = learned(where, ok)
    fresh = starts(200, seed + 50)
    foretold = np.array([probability(tried, s) >= tried.threshold for s in fresh])
    assert np.mean(foretold == (fresh[:, 0, 0] < 0.008)) > 0.8
    right, called = tried.precision
    found, good = tried.recall
    assert good == ok.sum() == 60 - tried.failures
    assert right / called > ok.mean() + 0.05
    assert found / good > 0.8


def test_failures_without_a_pattern_leave_precision_at_the_share_of_successes():
    where = starts(100, 4)
    ok = np.random.default_rng(1).uniform(size=100) < 0.8
    tried = learned(where, ok)
    right, called = tried.precision
    assert right / called == pytest.approx(ok.mean(), abs=0.06)


def test_each_start_is_foretold_from_the_others_alone():
    where = starts(12)
    ok = np.arange(12) % 4 > 0
    tried = learned(where, ok)
    for i in range(12):
        others = np.arange(12) != i
        assert tried.foretold[i] == probability(learned(where[others], ok[others]), where[i])


def test_words_say_whether_a_failure_was_ever_seen():
    assert str(learned(starts(26), np.ones(26))) == (
        "initiation set: precision 26/26, recall 26/26 (26 trials, none failed)"
    )
    assert str(learned(starts(26), np.arange(26) > 0)).endswith("(26 trials, 1 failed)")
    nothing_near = learned(starts(1), [1])
    assert (nothing_near.precision, nothing_near.recall) == ((0, 0), (0, 1))


@settings(max_examples=30, deadline=None)
@given(
    st.integers(1, 12),
    st.integers(0, 1000),
    st.lists(st.booleans(), min_size=12, max_size=12),
    st.floats(-1, 1),
    st.floats(-3, 3),
)
def test_p_is_a_probability_wherever_and_in_whatever_order_it_was_learned(count, seed, ok, x, yaw):
    where, ok = starts(count, seed), np.array(ok[:count], float)
    tried = learned(where, ok)
    here = compose(from_yaw(np.array([x, 0, 0]), yaw), starts(1, seed + 1)[0])
    p = probability(tried, here)
    assert 0 <= p <= count / (count + tried.doubt)
    shuffled = learned(where[::-1], ok[::-1])
    assert probability(shuffled, here) == pytest.approx(p, abs=1e-6)
    flipped = here * np.where(np.arange(7) < 3, 1.0, -1.0)
    assert probability(tried, flipped) == pytest.approx(p, abs=1e-9)


def test_starts_that_do_not_differ_are_one_place():
    tried = learned(np.repeat(starts(1), 5, axis=0), np.ones(5))
    assert probability(tried, starts(1)[0]) == pytest.approx(5 / 6)


def test_a_start_is_seen_from_the_reference_where_the_option_begins(short_demonstration):
    record = moved(still(short_demonstration), 0, [0.01, 0, 0])
    poses = record.object_poses.copy()
    poses[240:, 0, 0] += 0.1
    chained = replace(record, object_poses=poses, option_starts=(0, 240))
    names = short_demonstration.object_names
    before, after = start_of(chained, names, REACH, 1)[0], relative(poses[-1, 0], record.hand_poses[-1])
    assert before == pytest.approx(relative(poses[0, 0], record.hand_poses[0]))
    assert not np.allclose(before, after)
    on_table = seen_from(Abstraction(("hand",), "table"), names, np.vstack([record.hand_poses[:1], poses[0]]))
    assert on_table[0] == pytest.approx(record.hand_poses[0])
