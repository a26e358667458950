"""What makes a demonstration valid, and what is said when it is not."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.demonstration import (
    LONGEST,
    TABLE,
    Demonstration,
    in_table_frame,
    interpolated,
    span_in_words,
    table_height,
)
from imitate.errors import DemonstrationError
from imitate.geometry import IDENTITY, from_yaw


@pytest.fixture
def demonstration() -> Demonstration:
    t = np.array([3.0, 3.1, 3.25])
    hand = from_yaw(np.zeros((3, 3)), np.zeros(3))
    objects = from_yaw(np.full((3, 2, 3), 0.525), np.zeros((3, 2)))
    return Demonstration(t, hand, objects, ("blue", "green"), np.array([[0.05] * 3, [np.nan] * 3]))


def spoiled(values: np.ndarray, index: tuple, value: float) -> np.ndarray:
    changed = values.copy()
    changed[index] = value
    return changed


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: {"t": d.t[:1]}, r"t: shape \(1,\); expected \(T,\) with at least 2 frames"),
        (
            lambda d: {"t": d.t[[0, 2, 1]]},
            r"goes from 3.25 s to 3.1 s at frame 2; expected strictly increasing",
        ),
        (lambda d: {"t": d.t[[0, 0, 1]]}, r"goes from 3 s to 3 s at frame 1.*Remove repeated frames"),
        (
            lambda d: {"t": spoiled(d.t, (1,), np.nan)},
            "t: not a number at frame 1, 1 frames in all; expected seconds. Leave those frames out",
        ),
        (
            lambda d: {"t": spoiled(d.t, (2,), 3.1 + 86400)},
            r"t: 24 hours pass without a frame, from 0.1 s after the first \(frame 1\); expected 60",
        ),
        (
            lambda d: {"hand": d.hand[:2]},
            r"hand: shape \(2, 7\); expected \(3, 7\) for 3 frames and 2 objects",
        ),
        (lambda d: {"hand": d.hand[:, :6]}, r"hand: shape \(3, 6\); expected \(3, 7\)"),
        (
            lambda d: {"hand": spoiled(d.hand, (2, 0), np.nan)},
            "hand: NaN or infinite at frame 2, 1 frames in all",
        ),
        (lambda d: {"hand": spoiled(d.hand, (1, 6), 2.0)}, "hand: quaternion of length 2 at frame 1"),
        (lambda d: {"hand": spoiled(d.hand, (1, 6), 0.989)}, "hand: quaternion of length 0.989 at frame 1"),
        (
            lambda d: {"hand": spoiled(d.hand, (2, 0), -1e200)},
            r"hand: 1e\+200 at frame 2; expected metres and",
        ),
        (
            lambda d: {"objects": spoiled(d.objects, (0, 1, 2), np.inf)},
            r"objects\[:, 1\] \(green\): NaN or inf",
        ),
        (lambda d: {"objects": d.objects[:, :1]}, r"objects: shape \(3, 1, 7\); expected \(3, 2, 7\)"),
        (lambda _: {"object_names": ("blue", "blue")}, "blue, blue; expected distinct names"),
        (lambda _: {"object_names": ("blue", "hand")}, "none of them 'hand'"),
        (lambda _: {"object_names": ("blue", "table")}, "none of them 'hand' or 'table'"),
        (lambda d: {"hand": spoiled(d.hand, (slice(1, 3),), np.nan)}, "hand: seen in 1 frames; expected at"),
        (lambda _: {"object_names": ()}, "object_names: empty; expected at least one object"),
        (lambda d: {"object_sizes": d.object_sizes * -1}, "object_sizes: not positive"),
        (lambda _: {"opening": np.zeros((3, 1))}, r"opening: shape \(3, 1\); expected \(3,\)"),
        (
            lambda _: {"opening": np.array([0.1, np.nan, -0.01])},
            "opening: -0.01 m at frame 2; expected metres",
        ),
    ],
)
def test_what_is_wrong_is_said(demonstration, change, message):
    with pytest.raises(DemonstrationError, match=message):
        replace(demonstration, **change(demonstration))


def test_a_quaternion_of_nearly_length_one_is_scaled_to_it_and_one_of_it_is_kept(demonstration):
    hand = spoiled(demonstration.hand, (1, 6), 0.995)
    hand[2, 6] = np.nextafter(1, 0)
    rounded = replace(demonstration, hand=hand, objects=0.995 * demonstration.objects)
    assert rounded.hand[:, 6].tolist() == [1, 1, np.nextafter(1, 0)]
    np.testing.assert_allclose(np.linalg.norm(rounded.objects[..., 3:], axis=-1), 1, atol=1e-15)
    np.testing.assert_array_equal(rounded.objects[..., :3], 0.995 * demonstration.objects[..., :3])


def test_what_goes_through_time_in_even_steps_is_bounded(demonstration):
    t = np.arange(0, LONGEST + 100, 50.0)
    tiled = {"hand": np.tile(IDENTITY, (len(t), 1)), "objects": np.tile(IDENTITY, (len(t), 2, 1))}
    with pytest.raises(
        DemonstrationError, match=r"t: lasts 60\.8 minutes; expected 60 minutes at most\. Keep"
    ):
        replace(demonstration, t=t, **tiled)
    kept = t <= LONGEST
    whole = replace(demonstration, t=t[kept], **{name: poses[kept] for name, poses in tiled.items()})
    assert whole.duration == LONGEST


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.25, "0.25 s"),
        (95, "95 s"),
        (150, "2.5 minutes"),
        (26 * 3600, "26 hours"),
        (1.7e9, "19,676 days"),
        (130 * 86400, "130 days"),
    ],
)
def test_spans_of_time_in_words(seconds, words):
    assert span_in_words(seconds) == words


def test_poses_by_name(demonstration):
    assert demonstration.pose_of("hand") is demonstration.hand
    np.testing.assert_array_equal(demonstration.pose_of("green"), demonstration.objects[:, 1])
    np.testing.assert_array_equal(demonstration.size_of("blue"), [0.05] * 3)
    assert demonstration.duration == pytest.approx(0.25)


def test_the_table_is_where_the_lowest_object_of_known_size_stands(demonstration):
    assert table_height(demonstration) == pytest.approx(0.5)
    on_table = in_table_frame(demonstration)
    assert table_height(on_table) == pytest.approx(0)
    assert on_table.t[0] == 0
    np.testing.assert_allclose(on_table.hand[:, 2], -0.5)


def test_without_any_size_there_is_no_table(demonstration):
    unknown = replace(demonstration, object_sizes=np.full((2, 3), np.nan))
    with pytest.raises(DemonstrationError, match="no object's size is known"):
        table_height(unknown)


def test_a_pose_not_seen_is_missing_until_it_is_interpolated(demonstration):
    gap = replace(demonstration, objects=spoiled(demonstration.objects, (1, 0), np.nan))
    assert gap.seen("blue").tolist() == [True, False, True]
    assert gap.seen("green").all()
    filled = interpolated(gap)
    np.testing.assert_allclose(filled.objects, demonstration.objects)
    assert interpolated(demonstration) is demonstration


def test_an_object_first_seen_later_still_stands_on_the_table(demonstration):
    late = replace(demonstration, objects=spoiled(demonstration.objects, (0, 0), np.nan))
    assert table_height(late) == pytest.approx(0.5)


def test_the_table_is_a_body_that_stays(demonstration):
    np.testing.assert_array_equal(demonstration.pose_of(TABLE), [IDENTITY] * 3)


def test_nothing_can_be_changed(demonstration):
    d = replace(demonstration, opening=np.array([0.08, np.nan, 0.05]))
    for values in (d.t, d.hand, d.objects, d.object_sizes, d.opening):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0
