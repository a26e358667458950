"""A recording's pictures, small and by time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import scripted

from imitate.formats.recordings import open_recording
from imitate.formats.session_pictures import pictures_of
from imitate.formats.session_writer import SessionWriter
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception
from imitate.tui.album import MOST, WIDTH, Album, Shot, Wanted, opened, read_pictures, shot_of

STACK = Path(__file__).parents[2] / "fixtures" / "stack.mcap"


def test_the_nearest_picture_is_found() -> None:
    album = Album()
    assert album.nearest(1.0) is None
    for t in (0.0, 0.5, 1.5):
        album.take(Shot(t, b""))
    album.take(None)
    assert [album.nearest(t) for t in (-1, 0.2, 0.3, 1.1, 9)] == [album.shots[k] for k in (0, 0, 1, 2, 2)]


@pytest.mark.parametrize("shape", [(480, 640, 3), (100, 90, 3)])
def test_a_picture_is_made_small_and_keeps_its_form(shape: tuple[int, ...]) -> None:
    image = np.zeros(shape, np.uint8)
    image[:, : shape[1] // 2] = (200, 100, 20)
    small = opened(shot_of(0.0, image))
    assert small.shape[1] == min(WIDTH, shape[1])
    assert small.shape[0] / small.shape[1] == pytest.approx(shape[0] / shape[1], abs=0.01)
    assert np.abs(small[5, 5].astype(int) - (200, 100, 20)).max() < 12


def test_every_picture_of_a_recording_is_read_at_its_time() -> None:
    shots: list[Shot] = []
    read_pictures(Wanted(STACK, Perception()), shots.append, lambda: False)
    recording = open_recording(STACK)
    times = [frame.t for frame in recording.frames()]
    assert [shot.t for shot in shots] == pytest.approx([t - times[0] for t in times])
    assert len(shots) <= MOST


def test_reading_stops_when_it_is_asked_to() -> None:
    shots: list[Shot] = []
    read_pictures(Wanted(STACK, Perception()), shots.append, lambda: len(shots) >= 2)
    assert len(shots) == 2


@dataclass
class Camera:
    """Three frames of 8 × 6 pixels, a second apart, from second 3."""

    intrinsics = Intrinsics(8, 6, 10.0, 10.0, 4.0, 3.0)
    count = 3

    def frames(self) -> Iterator[RgbdFrame]:
        for k in range(self.count):
            colour = np.full((6, 8, 3), [200, 60 * k, 30], np.uint8)
            yield RgbdFrame(3.0 + k, colour, np.full((6, 8), 0.5, np.float32))


@pytest.mark.parametrize("kept", [True, False])
def test_a_session_has_the_pictures_that_it_keeps(tmp_path: Path, kept: bool) -> None:
    session = tmp_path / "session.mcap"
    with SessionWriter(session, pictures=pictures_of(Camera()) if kept else None) as log:
        for event in scripted.session():
            log.write(event)
    shots: list[Shot] = []
    read_pictures(Wanted(session, Perception()), shots.append, lambda: False)
    assert [shot.t for shot in shots] == ([0.0, 1.0, 2.0] if kept else [])
    for k, shot in enumerate(shots):
        assert np.abs(opened(shot)[3, 4].astype(int) - (200, 60 * k, 30)).max() < 12
