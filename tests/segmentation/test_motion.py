"""A body goes along when its point under the hand does, wherever its origin lies and however it turns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from imitate.geometry import compose, from_yaw
from imitate.segmentation.motion import going_along
from imitate.segmentation.tracks import track_of
from imitate.settings import load_settings

ROBUST = load_settings().segmentation
T = np.arange(90) / 30
WAY = from_yaw(np.column_stack([0.1 * T, 0.05 * np.sin(2 * T), 0 * T]), 0.4 * T)
HELD = compose(WAY, from_yaw(np.array([0.02, 0.01, 0.0]), 0.7))


def said(hand, body):
    """What each second says, in nats."""
    frames = going_along(T, track_of(T, hand, ROBUST), track_of(T, body, ROBUST), T, ROBUST)
    return float(np.sum(frames)) / T[-1]


def still(point, yaw=0.0):
    return np.tile(from_yaw(point, yaw), (len(T), 1))


def test_what_is_held_goes_along_and_what_stands_does_not():
    assert said(WAY, HELD) > 20
    assert said(WAY, still([0.1, 0.0, 0.0])) < -20


@hypothesis_settings(deadline=None, max_examples=20)
@given(offset=st.tuples(*[st.floats(-0.5, 0.5)] * 3), yaw=st.floats(-3, 3))
def test_it_does_not_matter_where_the_bodys_origin_lies(offset, yaw):
    other = from_yaw(np.array(offset), yaw)
    assert said(WAY, compose(HELD, other)) == pytest.approx(said(WAY, HELD), rel=0.02)
    assert said(WAY, compose(still([0.1, 0, 0]), other)) == pytest.approx(
        said(WAY, still([0.1, 0, 0])), rel=0.02
    )


@hypothesis_settings(deadline=None, max_examples=10)
@given(shift=st.tuples(*[st.floats(-2, 2)] * 3), yaw=st.floats(-3, 3))
def test_the_frame_does_not_matter(shift, yaw):
    world = from_yaw(np.array(shift), yaw)
    assert said(compose(world, WAY), compose(world, HELD)) == pytest.approx(said(WAY, HELD), rel=1e-6)


def test_a_door_turned_by_its_rim_goes_along_though_its_origin_stays():
    door = from_yaw(np.tile([0.3, 0.0, 0.0], (len(T), 1)), 0.3 * T)
    rim = compose(door, from_yaw([-0.3, 0.0, 0.0], 0.0))
    hooked = rim.copy()
    hooked[:, 3:] = [0, 0, 0, 1]
    assert said(rim, door) > 20
    assert said(hooked, door) > 20
    assert said(rim, still([0.3, 0.0, 0.0])) < -20


def test_a_knob_turned_on_the_spot_goes_along():
    turning = from_yaw(np.zeros((len(T), 3)), 0.8 * T)
    assert said(turning, turning) > 10
    wobbling = from_yaw(np.zeros((len(T), 3)), 0.001 * np.sin(T))
    assert said(turning, wobbling) < -10


def test_a_hand_at_rest_says_nothing_whatever_the_body_does():
    assert said(still([0, 0, 0]), HELD) <= 0
    assert said(still([0, 0, 0]), still([0.1, 0, 0])) == 0


def test_without_turns_seen_the_positions_speak():
    flat = HELD.copy()
    flat[:, 3:] = [0, 0, 0, 1]
    assert said(WAY, flat) > 20


def test_bodies_never_seen_together_say_nothing():
    early, late = WAY.copy(), HELD.copy()
    early[40:], late[:45] = np.nan, np.nan
    assert said(early, late) == 0


def test_gaps_say_what_their_ends_say():
    gaps = HELD.copy()
    gaps[20:30] = np.nan
    assert said(WAY, gaps) > 0.7 * said(WAY, HELD)


def test_noise_makes_it_less_sure_but_not_wrong():
    rng = np.random.default_rng(12)
    noisy = [
        poses + np.pad(rng.normal(scale=0.008, size=(len(T), 3)), ((0, 0), (0, 4))) for poses in (WAY, HELD)
    ]
    assert 0 < said(*noisy) < said(WAY, HELD)
