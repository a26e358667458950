"""Blocks and hand followed through drawn frames: lost and found, held, alike, without colour."""

import weakref

import numpy as np
import pytest
from drawn import Drawn, frame, real

from imitate.errors import ImitateError
from imitate.geometry import angle_between, compose, from_yaw
from imitate.perception.ahead import AHEAD
from imitate.perception.observe import observe
from imitate.settings import Settings

SIZE = (0.04, 0.05, 0.05)
HAND = np.array([-0.05, 0.12, 0.1, 0, 1, 0, 0])
FEW = Settings.model_validate({"perception": {"still_frames": 3}})


def lying(x, y, yaw=0.3, size=SIZE):
    return from_yaw([x, y, size[2] / 2], yaw)


def off(observation, name, poses):
    """Metres (T,) between where it was seen and where it was; NaN where it was not seen."""
    there = np.atleast_2d(real(observation, poses))
    return np.linalg.norm(observation.demonstration.pose_of(name)[:, :3] - there[:, :3], axis=1)


def test_what_rests_does_not_jitter_and_is_known_better_with_time():
    still = lying(0.02, -0.05)

    def draw(k, generator):
        return frame(k / 15, [("blue", still, SIZE)], HAND, generator)

    seen = observe(Drawn(45, draw), FEW)
    path = seen.demonstration.pose_of("blue")
    assert np.ptp(path[30:, :3], axis=0).max() < 1e-4
    assert angle_between(path[30], path[-1]) < 1e-3
    assert off(seen, "blue", still)[-1] < 0.002
    assert seen.lost == {} and seen.confidence[:, 1].min() > 0.9


def test_a_slow_push_is_followed():
    def pose(k):
        return lying(0.02 + 0.0004 * max(0, k - 15), -0.05)

    def draw(k, generator):
        return frame(k / 15, [("blue", pose(k), SIZE)], HAND, generator)

    seen = observe(Drawn(60, draw), FEW)
    assert off(seen, "blue", np.array([pose(k) for k in range(60)])).max() < 0.003


def test_what_was_hidden_and_moved_meanwhile_is_lost_then_found_lying_elsewhere():
    before, after = lying(0.0, 0.08), lying(0.05, -0.1, 0.9)
    boxes = [("green", lying(0.08, 0.15, 0), SIZE)]

    def draw(k, generator):
        board = (slice(0, 175), 0.4) if 12 <= k < 24 else None
        blue = ("blue", before if k < 18 else after, SIZE)
        hidden = [] if 12 <= k < 24 else [blue]
        return frame(k / 15, [*boxes, *hidden], HAND, generator, board=board)

    seen = observe(Drawn(40, draw), FEW)
    t = seen.demonstration.t
    assert seen.lost["blue"] == ((t[12], t[23]),)
    assert np.all(seen.confidence[12:24, 1] == 0) and seen.confidence[24:, 1].min() > 0.5
    away = off(seen, "blue", after)
    assert away[24:].max() < 0.004
    track = seen.demonstration.pose_of("blue")
    assert angle_between(track[11], track[24]) < np.deg2rad(46)  # 34° are shown; not turned by 180° more
    assert seen.lost_frames["blue"] == 12


def test_what_the_hand_carries_behind_a_board_comes_out_with_it():
    def hand(k):
        rise, go = 0.01 * np.clip(k - 4, 0, 6), 0.012 * np.clip(k - 12, 0, 18)
        return np.array([0, 0.1 - go, 0.03 + rise, 0, 1, 0, 0])

    in_hand = np.array([0, 0, 0.005, 0, 0, 0, 1.0])  # the block's centre, 2.5 cm above the table at first

    def draw(k, generator):
        board = (slice(130, 190), 0.4) if k >= 15 else None
        return frame(k / 15, [("green", compose(hand(k), in_hand), SIZE)], hand(k), generator, 0.052, board)

    seen = observe(Drawn(36, draw), Settings.model_validate({"perception": {"still_frames": 2}}))
    truth = np.array([compose(hand(k), in_hand) for k in range(36)])
    away = off(seen, "green", truth)
    assert np.nanmax(away) < 0.008
    assert np.isfinite(away[-3:]).all()


def test_blocks_of_one_hue_cross_without_being_confused():
    def pair(k):
        u = np.clip((k - 10) / 25, 0, 1)
        return lying(-0.06, 0.1 - 0.2 * u, 0.2), lying(0.06, -0.1 + 0.2 * u, -0.4)

    def draw(k, generator):
        return frame(k / 15, [("blue", pose, SIZE) for pose in pair(k)], HAND, generator)

    seen = observe(Drawn(45, draw), FEW)
    assert seen.demonstration.object_names == ("blue", "blue2")
    tracks = np.array([pair(k) for k in range(45)])
    order = [0, 1] if off(seen, "blue", tracks[:, 0])[0] < 0.02 else [1, 0]
    for name, which in zip(("blue", "blue2"), order, strict=True):
        assert off(seen, name, tracks[:, which]).max() < 0.004


def test_a_block_without_colour_is_followed_by_depth_alone():
    def pose(k):
        return lying(0.02, -0.1 + 0.006 * np.clip(k - 8, 0, 20))

    def draw(k, generator):
        return frame(k / 15, [("grey", pose(k), SIZE), ("blue", lying(0.1, 0.1), SIZE)], HAND, generator)

    seen = observe(Drawn(34, draw), FEW)
    assert "grey" in seen.demonstration.object_names
    away = off(seen, "grey", np.array([pose(k) for k in range(34)]))
    assert np.nanmedian(away) < 0.003 and np.nanmax(away) < 0.008
    assert seen.lost == {}


def test_the_hand_is_followed_while_one_finger_is_hidden():
    def hand(k):
        return HAND - [0, 0.006 * k, 0, 0, 0, 0, 0]

    def draw(k, generator):
        return frame(
            k / 15, [("blue", lying(0.05, 0), SIZE)], hand(k), generator, board=(slice(150, 165), 0.4)
        )

    seen = observe(Drawn(40, draw), FEW)
    away = off(seen, "hand", np.array([hand(k) for k in range(40)]))
    assert np.nanmedian(away) < 0.003 and np.nanmax(away) < 0.01
    assert np.isnan(away).sum() <= 2


def test_an_empty_table_is_said():
    with pytest.raises(ImitateError, match=r"nothing to follow stands on the table in the first view"):
        observe(Drawn(4, lambda k, generator: frame(k / 15, [], HAND, generator)), FEW)


def test_of_a_recording_only_poses_are_kept():
    """Frames are let go of: never more than those that are decoded ahead, and the still ones at the start."""
    still = lying(0.02, -0.05)
    given = []
    most = 0

    def draw(k, generator):
        nonlocal most
        shown = frame(k / 15, [("blue", still, SIZE)], HAND, generator)
        given.append(weakref.ref(shown))
        most = max(most, sum(frame() is not None for frame in given))
        return shown

    observe(Drawn(40, draw), FEW)
    assert most <= FEW.perception.still_frames + AHEAD + 3


def test_the_same_seed_gives_the_same_tracks():
    def draw(k, generator):
        return frame(k / 15, [("blue", lying(0.01 * k, 0), SIZE)], HAND, generator)

    a, b = (observe(Drawn(12, draw), FEW, seed=4) for _ in range(2))
    np.testing.assert_array_equal(a.demonstration.objects, b.demonstration.objects)
    np.testing.assert_array_equal(a.demonstration.hand, b.demonstration.hand)
    np.testing.assert_array_equal(a.confidence, b.confidence)
