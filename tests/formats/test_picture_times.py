"""Pictures by one clock: stamps that are off, missing or of two clocks; what a recording lost, and says."""

import cv2
import numpy as np
import pytest
from bags import bag

from imitate.errors import FileError
from imitate.formats.recordings import open_recording
from imitate.rgbd import Intrinsics

CAMERA = Intrinsics(64, 48, 60, 60, 31.5, 23.5)
COLOUR = np.full((48, 64, 3), 200, np.uint8)
DEPTH = np.full((48, 64), 1000, np.uint16)
COUNT = 60
T = np.arange(COUNT) / 10
START = 1_700_000_000.0


def film(path, colour, depth, logged=START + T):
    """A film whose colour and depth are stamped so; NaN where a picture is missing."""
    with bag(path) as made:
        made.info("/c/camera_info", CAMERA, START)
        for c, d, log in zip(colour, depth, logged, strict=True):
            if c == c:
                made.image("/c/colour", COLOUR, "rgb8", c, logged=log)
            if d == d:
                made.image("/c/depth", DEPTH, "16UC1", d, logged=log)
    return open_recording(path)


def changed(at, by):
    times = START + T
    times[at] += by
    return times


def times(recording):
    return [frame.t for frame in recording.frames()]


@pytest.mark.parametrize("which", ["colour", "depth"])
@pytest.mark.parametrize("by", [-30, 30, -START])
@pytest.mark.parametrize("at", [0, 20, COUNT - 1])
@pytest.mark.parametrize("logged_too", [False, True])
def test_one_picture_that_is_off_costs_one_frame(tmp_path, which, by, at, logged_too):
    stamps = {"colour": START + T, "depth": START + T, which: changed(at, by)}
    logged = changed(at, max(by, -30)) if logged_too else START + T
    opened = film(tmp_path / "film.mcap", **stamps, logged=logged)
    expected = np.delete(T, at)
    np.testing.assert_allclose(times(opened), expected - expected[0], atol=1e-6)
    assert opened.notes == [
        f"1 of 60 pictures of /c/{which} is left out: stamped more than 1 s off those before and after"
    ]
    assert opened.left_out == pytest.approx(1 / 60)
    list(opened.frames())
    assert len(opened.notes) == 1  # read twice, said once


def test_pictures_in_time_are_said_nothing_of(tmp_path):
    opened = film(tmp_path / "film.mcap", START + T, START + T)
    assert len(times(opened)) == COUNT
    assert (opened.notes, opened.left_out) == ([], 0)


@pytest.mark.parametrize(
    ("by", "words"),
    [
        (-30, r"/c/colour goes back in time by 29.9 s, 3.00 s after its first: its clock was set"),
        (86400, r"/c/colour has no picture for 24 hours, 3.00 s after its first: its clock was set"),
    ],
)
def test_a_clock_that_was_set_is_named(tmp_path, by, words):
    stamps = START + T + np.where(T > 3, by, 0)
    opened = film(tmp_path / "film.mcap", stamps, stamps)
    for read in (lambda: times(opened), opened.survey):
        with pytest.raises(FileError, match=f"{words}.*Keep the part before or after it; `mcap filter` cuts"):
            read()


def test_a_pause_is_said(tmp_path):
    stamps = START + T + np.where(T > 3, 20, 0)
    opened = film(tmp_path / "film.mcap", stamps, stamps, stamps)
    assert len(times(opened)) == COUNT
    (note,) = opened.notes
    assert note.startswith("20.1 s pass without a frame, from 3 s on: taken as one straight motion")


@pytest.mark.parametrize(
    ("colour", "depth", "why"),
    [
        (0 * T, START + T, "/c/colour has no stamps"),
        (START + T, 0 * T, "/c/depth has no stamps"),
        (0 * T, 0 * T, "/c/colour, /c/depth have no stamps"),
        (1 + T, START + T, "/c/colour, /c/depth are stamped by two clocks, 19,676 days apart"),
    ],
)
def test_one_clock_for_a_film(tmp_path, colour, depth, why):
    opened = film(tmp_path / "film.mcap", colour, depth)
    np.testing.assert_allclose(times(opened), T, atol=1e-6)
    assert opened.notes == [f"{why}: the log's times are used"]


def test_a_clock_that_starts_at_0_has_stamps(tmp_path):
    opened = film(tmp_path / "film.mcap", T, T, START + 3 * T)
    np.testing.assert_allclose(times(opened), T, atol=1e-6)
    assert opened.notes == []


def test_what_is_gone_is_counted_by_the_rarer_kind(tmp_path):
    k = np.arange(COUNT)
    gone = film(
        tmp_path / "a.mcap", np.where(k % 3, START + T, np.nan), np.where(k % 3 != 1, START + T, np.nan)
    )
    gone.survey()
    assert gone.left_out == 0.5
    assert gone.notes == ["40 of 80 pictures are left out: no other within 0.04 s (--pair-within)"]
    half = film(tmp_path / "b.mcap", START + T, np.where(k % 2, START + T, np.nan))
    half.survey()
    assert half.left_out == 0  # the depth camera is slower: each of its pictures is in a frame


def test_a_survey_finds_what_reading_finds(tmp_path):
    surveyed, read = (film(tmp_path / f"{k}.mcap", changed(20, -30), START + T) for k in range(2))
    surveyed.survey()
    list(read.frames())
    assert (surveyed.notes, surveyed.left_out) == (read.notes, read.left_out)


def tum(folder, unit=1, decimals=6, order=None, at=None, by=0):
    """A folder whose lists are in ``unit`` ticks a second."""
    for name, pixels in (("rgb", COLOUR), ("depth", DEPTH)):
        (folder / name).mkdir()
        cv2.imwrite(str(folder / name / "one.png"), pixels)
        stamps = START + T
        if at is not None and name == "rgb":
            stamps[at] += by
        lines = [f"{stamp * unit:.{decimals}f} {name}/one.png" for stamp in stamps]
        lines = [lines[k] for k in order] if order is not None else lines
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n")
    (folder / "calibration.txt").write_text("60 60 31.5 23.5\n")
    return open_recording(folder)


@pytest.mark.parametrize(
    ("unit", "name"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
)
def test_a_folder_s_times_since_1970_are_known_and_said(tmp_path, unit, name):
    opened = tum(tmp_path, unit, 0)
    np.testing.assert_allclose(times(opened), T, atol=1e-5)
    assert opened.notes == [
        f"{n} has times in {name} since 1970, and is read as such" for n in ("rgb.txt", "depth.txt")
    ]


def test_a_line_of_a_folder_s_list_that_is_off_costs_one_frame(tmp_path):
    opened = tum(tmp_path, at=20, by=-30)
    np.testing.assert_allclose(times(opened), np.delete(T, 20), atol=1e-5)
    assert opened.notes[0].startswith("1 of 60 pictures of rgb.txt is left out")


def test_a_folder_s_list_in_no_order_is_sorted(tmp_path):
    opened = tum(tmp_path, order=np.random.default_rng(0).permutation(COUNT))
    np.testing.assert_allclose(times(opened), T, atol=1e-5)
    assert opened.notes == []


def clouds(path, stamps, topics=("/points",)):
    points = CAMERA.rays().reshape(-1, 3)
    with bag(path) as made:
        for t, log in zip(stamps, START + T, strict=False):
            for topic in topics:
                made.cloud(topic, points, COLOUR.reshape(-1, 3), t, height=48, logged=log)
    return open_recording(path)


def test_clouds_keep_to_one_clock(tmp_path):
    off = changed(5, -START)[:20]
    opened = clouds(tmp_path / "a.mcap", off)
    opened.survey()
    np.testing.assert_allclose(times(opened), np.delete(T[:20], 5), atol=1e-6)
    assert opened.left_out == pytest.approx(1 / 20)
    assert opened.notes == [
        "1 of 20 clouds of /points is left out: stamped more than 1 s off those before and after"
    ]
    unstamped = clouds(tmp_path / "b.mcap", np.zeros(10))
    np.testing.assert_allclose(times(unstamped), T[:10], atol=1e-6)
    assert unstamped.notes == ["/points has no stamps: the log's times are used"]


def test_of_two_cameras_it_is_said_which_is_taken(tmp_path):
    opened = clouds(tmp_path / "clouds.mcap", START + T[:3], ("/a/points", "/b/points"))
    assert opened.notes == ["clouds are taken from /a/points, not from /b/points (--depth-topic)"]
    with bag(tmp_path / "two.mcap") as made:
        for name in ("a", "b"):
            made.info(f"/lens/{name}/info", CAMERA, frame=name)
        made.image("/colour", COLOUR, "rgb8")
        made.image("/depth", DEPTH, "16UC1")
    assert open_recording(tmp_path / "two.mcap").notes == [
        "the calibration is taken from /lens/a/info, not from /lens/b/info (--calibration-topic)"
    ]
