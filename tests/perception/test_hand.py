"""The hand from its fingers' pixels: its tips, told once and kept; other patches of a finger's colour."""

import numpy as np
import pytest
from drawn import INTRINSICS, YELLOW, camera, frame
from scipy.spatial.transform import Rotation

from imitate.geometry import angle_between, rotate
from imitate.perception.fingers import finger_colours
from imitate.perception.hand import Hand, hand_of_pixels
from imitate.perception.shapes import Pixels
from imitate.rgbd import RgbdFrame
from imitate.settings import Perception

DOWN = np.array([0, 0, 0.08, 0, 1, 0, 0])
CAMERA = camera()


def pixels(picture):
    """Those of a drawn frame, in the world's frame."""
    rays = rotate(CAMERA[3:], INTRINSICS.rays().reshape(-1, 3)).astype(np.float32)
    hue = finger_colours(Perception()).hues(picture.colour).reshape(-1)
    return Pixels(CAMERA[:3], rays, picture.depth.reshape(-1), hue)


def turned(degrees):
    """The hand that points down, turned about its y: at more than 90° its tips point up."""
    turn = Rotation.from_quat(DOWN[3:]) * Rotation.from_euler("y", degrees, degrees=True)
    return np.concatenate([DOWN[:3], turn.as_quat()])


def found(pose, before=None, picture=None):
    shown = frame(0, [], pose, np.random.default_rng(0)) if picture is None else picture
    hand = hand_of_pixels(pixels(shown), Perception(), before)
    assert hand is not None
    return hand.pose


@pytest.mark.parametrize("degrees", [-20, -10, 0, 20])
def test_a_hand_that_points_down_is_found_as_it_is(degrees):
    pose = turned(degrees)
    seen = found(pose)
    assert np.linalg.norm(seen[:3] - pose[:3]) < 0.01
    assert angle_between(seen, pose) < np.deg2rad(10)


def test_tips_that_have_been_turned_upwards_are_still_the_tips():
    pose = turned(-100)
    assert rotate(pose[3:], [0, 0, 1.0])[2] > 0
    assert angle_between(found(pose, Hand(turned(-80), 0.06)), pose) < np.deg2rad(12)
    assert angle_between(found(pose), pose) > np.deg2rad(90)  # by itself it cannot be told


def test_larger_patches_of_a_fingers_colour_are_not_the_finger():
    shown = frame(0, [], DOWN, np.random.default_rng(0))
    colour = np.array(shown.colour)
    colour[170:235, 20:150] = YELLOW  # a cloth on the table
    patched = RgbdFrame(0, colour, shown.depth)
    seen = found(DOWN, picture=patched)
    assert np.linalg.norm(seen[:3] - DOWN[:3]) < 0.01


def test_half_hidden_fingers_keep_their_direction():
    shown = frame(0, [], DOWN, np.random.default_rng(0))
    rows = np.flatnonzero((np.abs(shown.colour.astype(int) - YELLOW).sum(axis=2) < 30).any(axis=1))
    colour, depth = np.array(shown.colour), np.array(shown.depth)
    hidden = slice(0, int(rows.mean()))  # the upper half, by a board
    colour[hidden], depth[hidden] = 70, 0.3
    seen = found(DOWN, picture=RgbdFrame(0, colour, depth))
    assert np.linalg.norm(seen[:3] - DOWN[:3]) < 0.015
    assert angle_between(seen, DOWN) < np.deg2rad(20)


def test_a_missing_finger_is_no_hand():
    shown = frame(0, [], DOWN, np.random.default_rng(0))
    colour = np.array(shown.colour)
    colour[np.abs(colour.astype(int) - YELLOW).sum(axis=2) < 30] = 120
    assert hand_of_pixels(pixels(RgbdFrame(0, colour, shown.depth)), Perception()) is None
