"""The gripper's first weights from the hand's opening: closed while it was seen closed, open otherwise."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.demonstration import Demonstration
from imitate.geometry import IDENTITY
from imitate.learning.closing import seen_closed, with_opening
from imitate.learning.problem import formulate
from imitate.policy.force import forces
from imitate.settings import Settings, load_settings
from imitate.skill import Abstraction, Formulation, Policy, Segment

SETTINGS = Settings()
FAITHFUL = load_settings(overrides={"mode": "faithful"})
CARRY = Segment(2.0, 8.0, Abstraction(("hand", "blue"), "green"))
TICKS = 360
AT = np.linspace(CARRY.start, CARRY.end, TICKS)
T = np.arange(301) / 30


def shown(opening):
    poses = np.tile(IDENTITY, (len(T), 1))
    objects = np.stack([poses, poses], axis=1)
    return Demonstration(T, poses, objects, ("blue", "green"), np.full((2, 3), 0.04), opening)


def gripped(closing=2.5, opening=7.0, narrow=0.05, wide=0.08):
    """Fingers that take 0.3 s to close to ``narrow`` and to open to ``wide`` metres again."""
    return np.interp(T, [closing, closing + 0.3, opening, opening + 0.3], [wide, narrow, narrow, wide])


POLICY = Policy("green", 6.0, IDENTITY, IDENTITY, np.zeros((30, 6)), np.zeros(5))


@given(
    closing=st.floats(2.0, 4.0),
    lasting=st.floats(0.5, 3.0),
    narrow=st.floats(0.0, 0.06),
    drift=st.floats(-0.006, 0.006),
    seed=st.integers(0, 99),
)
def test_the_hand_is_seen_closed_while_it_is(closing, lasting, narrow, drift, seed):
    rng = np.random.default_rng(seed)
    opened = closing + 0.3 + lasting
    held = np.clip((T - closing - 0.3) / lasting, 0, 1) * (opened > T)
    noisy = gripped(closing, opened, narrow) + drift * held + rng.normal(0, 3e-4, len(T))
    closed = seen_closed(shown(np.maximum(noisy, 0)), CARRY, AT, SETTINGS.learning)
    assert closed[(closing + 0.4 < AT) & (opened - 0.1 > AT)].all()
    assert not closed[(closing - 0.1 > AT) | (opened + 0.4 < AT)].any()


@given(st.floats(0.5, 3.0))
def test_a_larger_gripper_closes_at_the_same_time(factor):
    usual = seen_closed(shown(gripped()), CARRY, AT, SETTINGS.learning)
    larger = seen_closed(shown(factor * gripped()), CARRY, AT, SETTINGS.learning)
    np.testing.assert_array_equal(larger, usual)


def test_frames_in_which_the_fingers_were_not_seen_are_bridged():
    gaps = gripped()
    gaps[100:150] = np.nan
    usual = seen_closed(shown(gripped()), CARRY, AT, SETTINGS.learning)
    np.testing.assert_array_equal(seen_closed(shown(gaps), CARRY, AT, SETTINGS.learning), usual)


@pytest.mark.parametrize(
    "opening",
    [None, np.full(len(T), 0.08), 0.05 + 0.006 * T / T[-1], np.where((T < 2) | (T > 8), 0.08, np.nan)],
    ids=["not observed", "never closed", "drift alone", "not seen in the segment"],
)
def test_where_nothing_tells_open_from_closed_there_are_no_weights(opening):
    assert with_opening(POLICY, shown(opening), CARRY, SETTINGS) is POLICY


@pytest.mark.parametrize(("closing", "opening"), [(2.2, 7.4), (2.5, 7.0), (3.0, 6.5), (2.5, 5.0)])
def test_the_weights_hold_what_was_held_and_let_go(closing, opening):
    policy = with_opening(POLICY, shown(gripped(closing, opening)), CARRY, SETTINGS)
    command = forces(policy, TICKS, 80.0, SETTINGS.policy)
    held = (closing + 0.9 < AT) & (opening - 0.4 > AT)
    assert command[held].min() > 10
    assert command.max() < 40
    assert (command[opening + 0.7 < AT] <= SETTINGS.policy.open_below).all()


def test_while_the_hand_waits_the_gripper_closes_and_it_opens_when_the_movement_is_as_far():
    waiting = with_opening(replace(POLICY, wait=0.5), shown(gripped()), CARRY, SETTINGS)
    command = forces(waiting, TICKS + 30, 80.0, SETTINGS.policy)
    at = np.arange(TICKS + 30) / 60 + CARRY.start
    assert command[(at > 2.5 + 0.9) & (at < 7.5 - 0.4)].min() > 10
    assert not command[at > 7.5 + 0.7].any()


def test_what_hangs_in_the_air_at_the_end_is_held_with_the_force_seen():
    hanging = with_opening(replace(POLICY, holds=True), shown(gripped(2.5, 9.5)), CARRY, SETTINGS)
    command = forces(hanging, TICKS, 80.0, SETTINGS.policy)
    assert command[-1] > 10
    assert forces(replace(hanging, holds=False), TICKS, 80.0, SETTINGS.policy)[-1] < 8


def test_a_formulation_starts_from_them_unless_the_force_is_to_be_discovered(stacking):
    demonstration, segments = stacking
    grip = np.where(demonstration.t - demonstration.t[0] < 1.0, 0.08, 0.045)
    seen = replace(demonstration, opening=grip)
    with_force = Formulation(0, 1, segments[0].abstraction, ("pose", "gripper"), "")
    assert not formulate(seen, segments, with_force, FAITHFUL).imitated.gripper_weights.any()
    assert formulate(seen, segments, with_force, SETTINGS).imitated.gripper_weights.any()
    assert not formulate(demonstration, segments, with_force, SETTINGS).imitated.gripper_weights.any()
    without = replace(with_force, actions=("pose",))
    assert not len(formulate(seen, segments, without, SETTINGS).imitated.gripper_weights)
