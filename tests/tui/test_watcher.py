"""The child's look over the tracker's shoulder, with made-up frames and a made-up clock."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded import same

from imitate.demonstration import Demonstration, in_table_frame
from imitate.geometry import IDENTITY
from imitate.perception import observe
from imitate.perception.hand import SIDES, finger_poses
from imitate.perception.tracker import UNSEEN, Sight
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception, Settings
from imitate.tui import engine, watcher
from imitate.tui.sighting import Sighting
from imitate.tui.teaching import Task
from imitate.tui.watcher import HIGHEST, WIDEST, Watcher, cast_of, small

FIXTURE = Path(__file__).parents[2] / "fixtures" / "stack.mcap"
CAMERA = Intrinsics(32, 24, 30, 30, 16, 12)
FIRST = SimpleNamespace(
    objects=[SimpleNamespace(name=name, block=SimpleNamespace(size=np.full(3, 0.04))) for name in "ab"],
    table=SimpleNamespace(table_from_camera=IDENTITY),
)


def moment(k: int, count: int) -> observe.Moment:
    """The hand is lost in every third frame, and everything moves."""
    pose = np.array([0.01 * k, 0, 1, 0, 0, 0, 1.0])
    hand = UNSEEN if k % 3 == 2 else Sight(pose, 0.5)
    colour = np.full((24, 32, 3), k % 256, np.uint8)
    frame = RgbdFrame(k / 10, colour, np.zeros((24, 32), np.float32))
    sights = (hand, Sight(pose + 1, 0.25), Sight(pose + 2, 1.0))
    opening = np.nan if hand is UNSEEN else 0.03
    return observe.Moment(frame, count, sights, opening, FIRST, CAMERA)  # type: ignore[arg-type]


def told(times: list[float], count: int) -> list[Sighting]:
    heard: list[Sighting] = []
    now = 0.0
    watch = Watcher(Perception(), heard.append, lambda: now)
    for k, step in enumerate(times):
        now += step
        watch(moment(k, count))
    watch.end()
    return heard


@given(st.lists(st.floats(0, 0.4), min_size=1, max_size=30))
def test_every_frame_is_told_once_and_in_order_whatever_the_clock(times: list[float]) -> None:
    heard = told(times, len(times) + 5)
    assert [one.begin for one in heard] == np.cumsum([0] + [len(one) for one in heard])[:-1].tolist()
    whole = heard[0]
    for one in heard[1:]:
        whole = whole.then(one)
    n = len(times)
    np.testing.assert_allclose(whole.t, np.arange(n) / 10)
    assert whole.lost[:, 0].tolist() == [k % 3 == 2 for k in range(n)]
    np.testing.assert_allclose(whole.confidence[:, 1], 0.25)
    np.testing.assert_allclose(whole.poses[:, 2, 0], 2 + 0.01 * np.arange(n))
    assert whole.share == 1  # there are fewer than the recording had said


def test_it_is_told_a_few_times_a_second_and_the_first_frame_at_once() -> None:
    heard = told([0.125] * 20, 20)
    assert [len(one) for one in heard] == [1, *[2] * 9, 1]
    assert [round(one.share, 2) for one in heard[:3]] == [0.05, 0.15, 0.25]


def test_of_a_long_recording_fewer_pictures_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watcher, "MOST", 4)
    heard = told([1.0] * 10, 10)
    kept = [k for k, one in enumerate(heard[:-1]) if one.pictures[0]]
    assert kept == [0, 3, 6, 9]


@given(st.integers(1, 700), st.integers(1, 700))
def test_pictures_are_small_and_keep_their_shape(height: int, width: int) -> None:
    data = small(np.zeros((height, width, 3), np.uint8))
    shown = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    high, wide = shown.shape[:2]
    assert high <= min(HIGHEST, height) and wide <= min(WIDEST, width)
    if min(high, wide) > 1:
        assert abs(wide / high - width / height) <= max(1 / high, 1 / wide) * (1 + width / height)


def test_colours_stay_what_they_are() -> None:
    red = np.zeros((240, 320, 3), np.uint8)
    red[..., 0] = 200
    data = np.frombuffer(small(red), np.uint8)
    np.testing.assert_allclose(cv2.imdecode(data, cv2.IMREAD_COLOR_RGB)[60, 80], [200, 0, 0], atol=4)


def test_fingers_are_drawn_where_the_tracker_looks_for_them() -> None:
    settings = Perception()
    cast = cast_of(moment(0, 1), settings)
    for finger, side in zip(cast.fingers, SIDES, strict=True):
        opened = finger.mean(axis=0) + np.array([0, side * 0.06 / 2, 0])
        (real,) = finger_poses(IDENTITY[None], np.array([0.06]), settings, side)
        np.testing.assert_allclose(opened, real[:3], atol=1e-3)
        assert np.ptp(finger[:, 2]) == pytest.approx(settings.finger_length)


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("open3d") is None, reason="open3d is not installed")
def test_the_child_tells_every_frame_and_finds_what_is_found_unwatched() -> None:
    task = Task(FIXTURE, Settings(), 3, 1, (), FIXTURE)
    *told, found = engine.observe(task, lambda: False)
    alone = observe.observe(FIXTURE, Settings(), 3)
    assert isinstance(found, Demonstration)
    assert same(found, in_table_frame(alone.demonstration))
    whole, *later = (one for one in told if isinstance(one, Sighting))
    assert len(later) + 1 == len(told) < len(alone.demonstration.t) / 2
    for one in later:
        whole = whole.then(one)
    assert whole.share == 1
    np.testing.assert_array_equal(whole.confidence, alone.confidence)
    np.testing.assert_array_equal(whole.poses[..., :3], all_poses(alone.demonstration)[..., :3])
    np.testing.assert_array_equal(whole.openings, alone.demonstration.opening)
    assert all(picture for picture in whole.pictures)


def all_poses(demonstration: Demonstration) -> np.ndarray:
    """(T, 1+K, 7) of hand and objects."""
    return np.concatenate([demonstration.hand[:, None], demonstration.objects], axis=1)
