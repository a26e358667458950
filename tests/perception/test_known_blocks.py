"""Blocks of known size and paint: found without a first view, followed, and lost honestly."""

import numpy as np
import pytest
from drawn import INTRINSICS, camera, frame

from imitate.geometry import angle_between, from_yaw
from imitate.perception.known_blocks import KnownBlocks
from imitate.perception.tracker import Motion
from imitate.settings import Perception

SIZES = np.array([[0.04, 0.04, 0.04], [0.04, 0.06, 0.05]])
HUES = ("blue", "green")
HERE = from_yaw([[0.02, -0.05, 0.02], [0.05, 0.08, 0.025]], [0.3, -0.4])


def blocks(expected=HERE, sought=True, seed=0):
    return KnownBlocks(
        INTRINSICS, camera(), HUES, SIZES, expected, Perception(), np.random.SeedSequence(seed), sought
    )


def shot(t, poses, generator, board=None):
    boxes = [(hue, pose, size) for hue, pose, size in zip(HUES, poses, SIZES, strict=True)]
    return frame(t, boxes, None, generator, board=board)


@pytest.mark.parametrize(("shift", "turn"), [(0.0, 0.0), (0.02, 15.0), (0.1, 40.0)])
def test_they_are_found_wherever_they_stand(shift, turn):
    generator = np.random.default_rng(0)
    yaws = np.array([0.3, -0.4]) + np.deg2rad(turn) * np.array([1, -1])
    there = from_yaw(HERE[:, :3] + [[shift, -shift, 0], [-shift, shift / 2, 0]], yaws)
    seeking = blocks()
    for k in range(4):
        seen = seeking.follow(shot(k / 10, there, generator), None)
    assert np.linalg.norm(seen[:, :3] - there[:, :3], axis=1).max() < 0.003
    assert np.rad2deg(angle_between(seen, there)).max() < 4


def test_a_cube_a_quarter_turned_is_told_as_the_nearest_that_looks_the_same():
    turned = from_yaw(HERE[:, :3], [0.3 + np.pi / 2, -0.4])
    generator, seeking = np.random.default_rng(1), blocks()
    for k in range(4):
        seen = seeking.follow(shot(k / 10, turned, generator), None)
    assert angle_between(seen[0], HERE[0]) < 0.1


def test_what_the_hand_carries_is_followed_at_two_looks_a_second():
    generator, following = np.random.default_rng(2), blocks(sought=False)
    path = [HERE[0] + np.array([0, 0, 0.03 * k, 0, 0, 0, 0]) for k in range(4)]
    before = None
    for k, pose in enumerate(path):
        motion = None if before is None else Motion(before, pose)
        seen = following.follow(shot(k / 2, [pose, HERE[1]], generator), motion)
        before = pose
        assert np.linalg.norm(seen[0, :3] - pose[:3]) < 0.004


def test_what_is_hidden_where_it_was_seen_is_still_there_and_comes_back():
    generator, following = np.random.default_rng(3), blocks()
    before = following.follow(shot(0, HERE, generator), None)
    hidden = following.follow(shot(0.1, HERE, generator, (slice(160, 320), 0.4)), None)
    assert np.array_equal(hidden[0], before[0])
    again = following.follow(shot(0.2, HERE, generator), None)
    assert np.linalg.norm(again[0, :3] - HERE[0, :3]) < 0.004


def test_what_has_left_its_place_is_not_seen():
    generator, following = np.random.default_rng(3), blocks()
    following.follow(shot(0, HERE, generator), None)
    gone = HERE - np.array([[0, 0, 3, 0, 0, 0, 0], [0] * 7])
    seen = following.follow(shot(0.1, gone, generator), None)
    assert np.isnan(seen[0]).all()
    assert not np.isnan(seen[1]).any()


def test_a_block_that_is_not_there_is_not_found():
    gone = np.array([HERE[0], HERE[1] - [0, 0, 3, 0, 0, 0, 0]])
    seen = blocks().follow(shot(0, gone, np.random.default_rng(4)), None)
    assert np.isnan(seen[1]).all()


def test_the_same_seed_sees_the_same():
    def seen(seed):
        return blocks(seed=seed).follow(shot(0, HERE, np.random.default_rng(5)), None).tobytes()

    assert seen(0) == seen(0) != seen(1)
