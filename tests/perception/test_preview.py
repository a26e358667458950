"""Previews: what is drawn lies where the camera sees it; what was lost is said; files come out right."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from imitate.errors import FileError
from imitate.formats.recordings import open_recording
from imitate.geometry import compose
from imitate.perception.preview import (
    INK,
    LOST,
    Sketch,
    draw_first_view,
    draw_frame,
    draw_tracks,
    write_film,
    write_picture,
)
from imitate.rgbd import Intrinsics
from imitate.settings import Perception

CAMERA = Intrinsics(640, 480, 500, 500, 319.5, 239.5)
GREY = np.full((480, 640, 3), 90, np.uint8)
STILL = np.array([0, 0, 1.0, 0, 0, 0, 1])


def inked(image, ink):
    """(rows, columns) of the pixels of that colour."""
    return np.nonzero((np.abs(image.astype(int) - ink) < 12).all(axis=2))


def test_a_box_is_drawn_where_its_corners_are():
    sketch = Sketch(GREY, CAMERA)
    sketch.box(STILL, np.array([0.2, 0.1, 0.1]), (255, 0, 0))
    rows, columns = inked(sketch.image, (255, 0, 0))
    nearest = 500 * 0.1 / 0.95, 500 * 0.05 / 0.95  # half its width and height, on the face that is nearer
    assert abs(columns.max() - (319.5 + nearest[0])) < 2 and abs(columns.min() - (319.5 - nearest[0])) < 2
    assert abs(rows.max() - (239.5 + nearest[1])) < 2 and abs(rows.min() - (239.5 - nearest[1])) < 2
    assert (sketch.image[239, 319] == 90).all()  # edges alone


def test_nothing_behind_the_camera_or_unknown_is_drawn():
    sketch = Sketch(GREY, CAMERA)
    sketch.box(np.array([0, 0, -1.0, 0, 0, 0, 1]), np.full(3, 0.1), (255, 0, 0))
    sketch.line(np.array([[0, 0, 1.0], [np.nan] * 3, [0.1, 0, 1]]), (255, 0, 0))
    sketch.name("far", np.array([0, 0, -1.0]), (255, 0, 0))
    assert (sketch.image == 90).all()


def test_small_pictures_are_enlarged():
    small = Sketch(GREY[::4, ::4], Intrinsics(160, 120, 125, 125, 79.5, 59.5))
    small.box(STILL, np.array([0.2, 0.1, 0.1]), (255, 0, 0))
    large = Sketch(GREY, CAMERA)
    large.box(STILL, np.array([0.2, 0.1, 0.1]), (255, 0, 0))
    np.testing.assert_array_equal(small.image, large.image)


def test_frames_show_what_was_seen_and_say_what_was_lost(filmed, observed):
    recording = open_recording(filmed.path)
    frame = next(recording.frames())
    settings = Perception()
    image = draw_frame(frame, recording.intrinsics, observed, 0, settings)
    assert all(len(inked(image, ink)[0]) > 20 for ink in INK[:3])
    assert not len(inked(image, LOST)[0])
    d = observed.demonstration
    objects = np.array(d.objects)
    objects[0, 0] = np.nan
    unseen = replace(observed, demonstration=replace(d, objects=objects))
    without = draw_frame(frame, recording.intrinsics, unseen, 0, settings)
    assert not len(inked(without, INK[1])[0])
    assert len(inked(without, LOST)[0]) > 20
    tracks = draw_tracks(frame, recording.intrinsics, observed, settings)
    assert tracks.shape == image.shape
    carried = compose(observed.camera_from_table, d.pose_of("blue"))[len(d.t) // 2, :3]
    i, scale = recording.intrinsics, image.shape[0] / frame.colour.shape[0]
    column, row = (carried[:2] / carried[2] * [i.fx, i.fy] + [i.cx, i.cy] + 0.5) * scale - 0.5
    rows, columns = inked(tracks, INK[1])
    assert np.hypot(rows - row, columns - column).min() < 3


def test_a_first_view_tints_its_objects(filmed, observed):
    recording = open_recording(filmed.path)
    frame = next(recording.frames())
    image = draw_first_view(frame.colour, recording.intrinsics, observed.first)
    scale = image.shape[0] // frame.colour.shape[0]
    labels = observed.first.labels.reshape(frame.colour.shape[:2])
    for n in range(len(observed.first.objects)):
        row, column = (int(np.median(k)) for k in np.nonzero(labels == n + 1))
        if labels[row, column] == n + 1:
            change = image[scale * row, scale * column].astype(int) - frame.colour[row, column]
            assert np.abs(change).max() > 20


def test_written_as_a_picture_and_as_a_film(tmp_path):
    image = np.array(GREY)
    image[:, :320] = (200, 30, 30)
    write_picture(tmp_path / "a.png", image)
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "a.png"))[..., ::-1], image)
    write_film(tmp_path / "a.mp4", [image] * 5, 12.0)
    film = cv2.VideoCapture(str(tmp_path / "a.mp4"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == 5
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx(12)
    np.testing.assert_allclose(film.read()[1][240, 100, ::-1], (200, 30, 30), atol=12)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mp4", "a.png"]
    with pytest.raises(FileError, match=r"a.png: exists already.*--force"):
        write_picture(tmp_path / "a.png", image)
