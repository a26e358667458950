"""Recordings of ROS 2: every encoding, topics found or named, two cameras made one, and what is refused."""

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from bags import bag, png

from imitate.errors import FileError
from imitate.formats.kind import kind_of
from imitate.formats.recordings import open_recording
from imitate.geometry import rotate
from imitate.rgbd import Intrinsics
from imitate.settings import Perception

CAMERA = Intrinsics(64, 48, 60.0, 60.0, 31.5, 23.5)
FOREIGN = Path(__file__).parents[3] / "shared" / "data" / "mcap" / "foreign"
COLOUR = np.full((48, 64, 3), (200, 120, 30), np.uint8)
STEPS = np.random.default_rng(0).integers(600, 1400, (48, 64)).astype(np.uint16)
STEPS[:4] = 0
METRES = STEPS / 1000


def write(path, colour=(COLOUR, "rgb8"), depth=(STEPS, "16UC1"), times=(0.0, 0.033, 0.066), offset=0.004):
    with bag(path) as made:
        for t in times:
            made.info("/camera/camera_info", CAMERA, t)
            made.image("/camera/depth", *depth, t=t)
            made.image("/camera/colour", *colour, t=t + offset)
    return path


def inverse_depth(metres):
    """compressedDepth of 32FC1: a header of two parameters, and a PNG of a / depth + b."""
    a, b = 100.0 * 101.0, -99.0
    steps = np.where(metres > 0, a / np.maximum(metres, 1e-3) + b, 0).astype(np.uint16)
    return struct.pack("<iff", 0, a, b) + png(steps)


@pytest.mark.parametrize(
    ("pixels", "encoding"),
    [
        (COLOUR, "rgb8"),
        (COLOUR[..., ::-1], "bgr8"),
        (COLOUR[..., ::-1], "8UC3"),
        (np.dstack([COLOUR, COLOUR[..., :1]]), "rgba8"),
        (np.dstack([COLOUR[..., ::-1], COLOUR[..., :1]]), "bgra8"),
    ],
)
def test_colour_in_every_encoding(tmp_path, pixels, encoding):
    path = write(tmp_path / "bag.mcap", colour=(pixels, encoding))
    assert kind_of(path) == "recording"
    opened = open_recording(path)
    assert opened.intrinsics == CAMERA
    frames = list(opened.frames())
    assert [frame.t for frame in frames] == pytest.approx([0, 0.033, 0.066])
    for frame in frames:
        np.testing.assert_array_equal(frame.colour, COLOUR)
        np.testing.assert_allclose(frame.depth, METRES, atol=1e-6)


def test_grey_and_bayer_are_colours_too(tmp_path):
    path = write(tmp_path / "grey.mcap", colour=(COLOUR[..., 0], "mono8"))
    assert (next(open_recording(path).frames()).colour == 200).all()
    mosaic = np.zeros((48, 64), np.uint8)
    mosaic[::2, ::2], mosaic[1::2, 1::2] = 200, 30
    mosaic[::2, 1::2] = mosaic[1::2, ::2] = 120
    path = write(tmp_path / "bayer.mcap", colour=(mosaic, "bayer_rggb8"))
    frame = next(open_recording(path).frames())
    np.testing.assert_allclose(frame.colour[4:-4, 4:-4], COLOUR[4:-4, 4:-4], atol=2)


@pytest.mark.parametrize(
    "depth",
    [
        (STEPS, "16UC1"),
        (STEPS, "mono16"),
        (STEPS.astype(">u2"), "16UC1"),
        (METRES.astype(np.float32), "32FC1"),
        (np.where(METRES > 0, METRES, np.nan).astype(np.float32), "32FC1"),
        (np.where(METRES > 0, METRES, np.inf).astype(np.float32), "32FC1"),
    ],
)
def test_depth_in_every_encoding(tmp_path, depth):
    path = write(tmp_path / "bag.mcap", depth=depth)
    for frame in open_recording(path).frames():
        np.testing.assert_allclose(frame.depth, METRES, atol=1e-6)


@pytest.mark.parametrize(
    ("form", "data", "tolerance"),
    [
        ("16UC1; compressedDepth png", struct.pack("<iff", 0, 0, 0) + png(STEPS), 1e-6),
        ("16UC1; compressedDepth", struct.pack("<iff", 0, 0, 0) + png(STEPS), 1e-6),
        ("32FC1; compressedDepth png", inverse_depth(METRES), 1e-3),
        ("16UC1; png compressed ", png(STEPS), 1e-6),
        ("png", png(STEPS), 1e-6),
    ],
)
def test_compressed_depth(tmp_path, form, data, tolerance):
    with bag(tmp_path / "bag.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        made.compressed("/c/depth/compressedDepth", data, form)
        made.compressed("/c/colour/compressed", png(COLOUR[..., ::-1]), "rgb8; png compressed bgr8")
    (frame,) = open_recording(tmp_path / "bag.mcap").frames()
    np.testing.assert_allclose(frame.depth, METRES, atol=tolerance)
    np.testing.assert_array_equal(frame.colour, COLOUR)


@pytest.mark.parametrize(
    ("form", "swapped"),
    [
        ("jpeg", False),
        ("rgb8; jpeg compressed bgr8", False),
        ("bgr8; jpeg compressed bgr8", False),
        ("rgb8; jpeg compressed rgb8", True),
    ],
)
def test_compressed_colour_keeps_red_and_blue_apart(tmp_path, form, swapped):
    data = cv2.imencode(".jpg", COLOUR if swapped else COLOUR[..., ::-1])[1].tobytes()
    with bag(tmp_path / "bag.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        made.image("/c/depth", STEPS, "16UC1")
        made.compressed("/c/colour/compressed", data, form)
    (frame,) = open_recording(tmp_path / "bag.mcap").frames()
    np.testing.assert_allclose(frame.colour.astype(int), COLOUR, atol=4)


def test_rows_with_padding(tmp_path):
    with bag(tmp_path / "bag.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        made.image("/c/depth", STEPS, "16UC1", padding=6)
        made.image("/c/colour", COLOUR, "rgb8", padding=5)
    (frame,) = open_recording(tmp_path / "bag.mcap").frames()
    np.testing.assert_allclose(frame.depth, METRES, atol=1e-6)
    np.testing.assert_array_equal(frame.colour, COLOUR)


def test_written_by_topic_and_out_of_order(tmp_path):
    with bag(tmp_path / "bag.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        for k in range(12):
            made.image("/c/depth", STEPS + np.uint16(k) * (STEPS > 0), "16UC1", 0.1 * k, logged=0.1 * k + 0.5)
        for k in (1, 0, 2, 3, 5, 4, 6, 7, 8, 9, 10, 11):
            made.image(
                "/c/colour", np.full_like(COLOUR, 10 * k), "rgb8", 0.1 * k + 0.01, logged=0.1 * k + 0.5
            )
    frames = list(open_recording(tmp_path / "bag.mcap").frames())
    assert [frame.t for frame in frames] == pytest.approx(list(np.arange(12) / 10))
    for k, frame in enumerate(frames):
        assert (frame.colour == 10 * k).all()
        np.testing.assert_allclose(frame.depth, METRES + 0.001 * k * (METRES > 0), atol=1e-6)


def realsense(path, aligned=True):
    """Topics as a RealSense's driver names them: infrared and depth of another camera, and their frames."""
    pose = [0.015, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    other = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5)
    with bag(path) as made:
        made.info("/cam/color/camera_info", CAMERA, frame="color_optical")
        made.info("/cam/depth/camera_info", other, frame="depth_optical")
        made.info("/cam/infra1/camera_info", other, frame="depth_optical")
        made.transform("/tf_static", "link", "color_optical", pose)
        made.transform("/tf_static", "link", "depth_optical", [0.0, 0, 0, 0, 0, 0, 1])
        for k in range(3):
            made.image("/cam/infra1/image_rect_raw", COLOUR[..., 0], "mono8", k / 10, "depth_optical")
            made.image("/cam/depth/image_rect_raw", 2 * STEPS, "16UC1", k / 10, "depth_optical")
            made.image("/cam/color/image_raw", COLOUR, "rgb8", k / 10, "color_optical")
            if aligned:
                made.image("/cam/aligned_depth_to_color/image_raw", STEPS, "16UC1", k / 10, "color_optical")
    return path


def test_registered_depth_is_preferred_and_said(tmp_path):
    opened = open_recording(realsense(tmp_path / "rs.mcap"))
    assert (opened.colour, opened.depth) == ("/cam/color/image_raw", "/cam/aligned_depth_to_color/image_raw")
    assert opened.intrinsics == CAMERA
    assert opened.notes == [
        "colour is taken from /cam/color/image_raw, not from /cam/infra1/image_rect_raw (--colour-topic)",
        "depth is taken from /cam/aligned_depth_to_color/image_raw, not from /cam/depth/image_rect_raw "
        "(--depth-topic)",
    ]
    np.testing.assert_allclose(next(opened.frames()).depth, METRES, atol=1e-6)


def test_topics_may_be_named(tmp_path):
    path = realsense(tmp_path / "rs.mcap")
    opened = open_recording(path, Perception(depth_topic="/cam/depth/image_rect_raw"))
    assert opened.intrinsics.fx == 50
    np.testing.assert_allclose(next(opened.frames()).depth, 2 * METRES, atol=1e-6)
    both = Perception(colour_topic="/cam/infra1/image_rect_raw", depth_topic="/cam/depth/image_rect_raw")
    assert (next(open_recording(path, both).frames()).colour == 200).all()
    for settings, words in (
        (Perception(depth_topic="/cam/color/image_raw"), "has no depth in topic '/cam/color/image_raw': its"),
        (
            Perception(colour_topic="/c"),
            r"its colour topics are /cam/color/image_raw, /cam/inf.*colour-topic",
        ),
        (Perception(calibration_topic="/c"), "its calibration topics are /cam/color/camera_info, "),
    ):
        with pytest.raises(FileError, match=words):
            open_recording(path, settings)


def two_cameras(path, pose, transform=True, d=(0.0,) * 5, model="plumb_bob"):
    """A red square in front of a grey wall, as a colour camera beside the depth camera sees it."""
    depth_camera, colour_camera = (
        Intrinsics(64, 48, 60, 60, 31.5, 23.5),
        Intrinsics(160, 120, 150, 150, 79.5, 59.5),
    )
    depth = np.full((48, 64), 2.0, np.float32)
    depth[16:32, 24:40] = 1.0
    corners = np.array([[23.5, 15.5], [39.5, 31.5]])
    points = np.column_stack([(corners - [31.5, 23.5]) / 60, np.ones(2)])
    there = pose[:3] + rotate(pose[3:], points)
    (u0, v0), (u1, v1) = there[:, :2] / there[:, 2:] * 150 + [79.5, 59.5]
    colour = np.full((120, 160, 3), 90, np.uint8)
    colour[round(v0 + 0.5) : round(v1 + 0.5), round(u0 + 0.5) : round(u1 + 0.5)] = (220, 30, 30)
    with bag(path) as made:
        made.info("/c/camera_info", colour_camera, frame="colour", model=model, d=d)
        made.info("/d/camera_info", depth_camera, frame="depth")
        if transform:
            made.transform("/tf_static", "colour", "depth", pose)
        made.image("/d/image", depth, "32FC1", frame="depth")
        made.image("/c/image", colour, "rgb8", frame="colour")
    return path, depth


POSE = np.array([0.05, 0.01, 0.0, 0, 0, 0, 1])


@pytest.mark.parametrize("told", ["transform", "given"])
def test_two_cameras_are_registered(tmp_path, told):
    path, depth = two_cameras(tmp_path / "two.mcap", POSE, transform=told == "transform")
    settings = Perception() if told == "transform" else Perception(colour_from_depth=tuple(POSE))
    opened = open_recording(path, settings)
    (frame,) = opened.frames()
    assert opened.intrinsics == Intrinsics(64, 48, 60, 60, 31.5, 23.5)
    np.testing.assert_allclose(frame.depth, depth)
    red = frame.colour[..., 0].astype(int) - frame.colour[..., 2] > 60
    near = depth < 1.5
    assert (red & near).sum() > 0.9 * near.sum()
    # what the square hides from the colour camera has no colour, least of all the square's
    assert (red & ~near).sum() < 0.1 * near.sum()
    hidden = (frame.colour == 0).all(axis=2)
    assert 0 < hidden.sum() < 0.5 * near.sum() and not (hidden & near).any()


def test_two_cameras_and_nothing_between_them(tmp_path):
    path, _ = two_cameras(tmp_path / "two.mcap", POSE, transform=False)
    words = r"are of two cameras, and no transform leads from one to the other.*--colour-from-depth X,Y,Z"
    with pytest.raises(FileError, match=words):
        open_recording(path)


def test_distortion_is_undone_or_refused(tmp_path):
    path, _ = two_cameras(tmp_path / "barrel.mcap", POSE, d=(-0.3, 0.1, 0, 0, 0))
    straight, _ = two_cameras(tmp_path / "straight.mcap", POSE)
    bent, plain = (next(open_recording(p).frames()).colour for p in (path, straight))
    middle = np.s_[20:28, 28:36]
    np.testing.assert_array_equal(bent[middle], plain[middle])
    assert (bent != plain).any()
    path, _ = two_cameras(tmp_path / "odd.mcap", POSE, model="inverse_brown_conrady", d=(0.1, 0, 0, 0, 0))
    with pytest.raises(FileError, match=r"a model that is not known: 'inverse_brown_conrady' with 5 coeff"):
        open_recording(path)


def test_a_straight_grid_comes_back_from_a_barrel(tmp_path):
    """A point far from the middle is moved to where the pinhole camera sees it."""
    camera, d = Intrinsics(160, 120, 120.0, 120.0, 79.5, 59.5), (-0.25, 0.05, 0.0, 0.0, 0.0)
    place = np.array([0.5, 0.35, 1.0])
    k = np.array([[120, 0, 79.5], [0, 120, 59.5], [0, 0, 1.0]])
    seen = cv2.projectPoints(place[None], np.zeros(3), np.zeros(3), k, np.array(d))[0].reshape(2)
    colour, depth = np.zeros((120, 160, 3), np.uint8), np.ones((120, 160), np.float32)
    cv2.circle(colour, tuple(round(float(v)) for v in seen), 3, (255, 255, 255), -1)
    depth[colour[..., 0] > 0] = 0.8
    with bag(tmp_path / "bag.mcap") as made:
        made.info("/c/camera_info", camera, d=d)
        made.image("/c/depth", depth, "32FC1")
        made.image("/c/colour", colour, "rgb8")
    (frame,) = open_recording(tmp_path / "bag.mcap").frames()
    wanted = np.array([120 * 0.5 + 79.5, 120 * 0.35 + 59.5])
    for mask in (frame.colour[..., 0] > 128, np.abs(frame.depth - 0.8) < 0.01):
        rows, columns = np.nonzero(mask)
        np.testing.assert_allclose([columns.mean(), rows.mean()], wanted, atol=0.8)


def test_intrinsics_may_be_given(tmp_path):
    with bag(tmp_path / "bag.mcap") as made:
        made.image("/depth", STEPS, "16UC1")
        made.image("/colour", COLOUR, "rgb8")
    with pytest.raises(FileError, match=r"has no calibration of its camera.*CameraInfo.*--intrinsics FX,FY"):
        open_recording(tmp_path / "bag.mcap")
    opened = open_recording(tmp_path / "bag.mcap", Perception(intrinsics=(60, 60, 31.5, 23.5)))
    assert opened.intrinsics == CAMERA
    assert len(list(opened.frames())) == 1


@pytest.mark.parametrize(
    ("depth", "words"),
    [
        ((STEPS.astype(np.float32), "32FC1"), r"\(32FC1\) holds depths in an unknown unit: at 1 m a step"),
        (
            (np.uint16(40) * (STEPS > 0).astype(np.uint16), "16UC1"),
            r"at 0.001 m a step its middle reading is 0.04 m",
        ),
    ],
)
def test_depth_in_an_unknown_unit(tmp_path, depth, words):
    path = write(tmp_path / "bag.mcap", depth=depth)
    with pytest.raises(FileError, match=rf"{words}.*--depth-unit 0.001 for millimetres"):
        list(open_recording(path).frames())
    unit = 1.0 / float(np.median(depth[0][depth[0] > 0]))
    frame = next(open_recording(path, Perception(depth_unit=unit)).frames())
    assert np.median(frame.depth[frame.depth > 0]) == pytest.approx(1, abs=0.01)


def test_a_camera_that_reads_nothing(tmp_path):
    path = write(tmp_path / "bag.mcap", depth=(0 * STEPS, "16UC1"))
    with pytest.raises(FileError, match=r"/camera/depth has no reading in any picture.*--depth-topic"):
        list(open_recording(path).frames())


def test_colour_and_depth_that_never_pair(tmp_path):
    path = write(tmp_path / "bag.mcap", offset=7.25)
    words = r"within 0.04 s: 3 pictures in /camera/colour, 3 in /camera/depth; the nearest two are 7.184 s"
    with pytest.raises(FileError, match=words):
        list(open_recording(path).frames())


def test_pictures_left_out_are_told(tmp_path):
    path = write(tmp_path / "bag.mcap", times=(0.0, 1.0, 2.0), offset=0.03)
    assert len(list(open_recording(path).frames())) == 3
    opened = open_recording(path, Perception(pair_within=0.02))
    with pytest.raises(FileError, match="Pass more seconds with --pair-within"):
        list(opened.frames())
    with bag(tmp_path / "half.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        for k in range(10):
            made.image("/c/depth", STEPS, "16UC1", k / 10)
            if k % 2:
                made.image("/c/colour", COLOUR, "rgb8", k / 10)
    opened = open_recording(tmp_path / "half.mcap")
    assert len(list(opened.frames())) == 5
    assert opened.notes == ["5 of 15 pictures are left out: no other within 0.04 s (--pair-within)"]


def test_a_picture_that_cannot_be_decoded_matters_only_where_it_is_needed(tmp_path):
    with bag(tmp_path / "bag.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        made.compressed("/c/colour/h264", b"\x00\x00\x00\x01", "h264")
        made.image("/c/depth", STEPS, "16UC1")
        made.image("/c/colour", COLOUR, "rgb8")
    assert len(list(open_recording(tmp_path / "bag.mcap").frames())) == 1
    with pytest.raises(FileError, match="/c/colour/h264 holds a h264 picture that cannot be decoded"):
        open_recording(tmp_path / "bag.mcap", Perception(colour_topic="/c/colour/h264"))
    with bag(tmp_path / "rvl.mcap") as made:
        made.info("/c/camera_info", CAMERA)
        made.compressed("/c/d", struct.pack("<iff", 0, 0, 0) + b"1234", "16UC1; compressedDepth rvl")
        made.image("/c/colour", COLOUR, "rgb8")
    with pytest.raises(FileError, match="16UC1; compressedDepth rvl picture that cannot be decoded"):
        open_recording(tmp_path / "rvl.mcap")


def test_a_cut_bag_is_refused_or_salvaged(tmp_path):
    generator = np.random.default_rng(1)
    noise = generator.integers(0, 255, COLOUR.shape).astype(np.uint8)
    path = write(tmp_path / "bag.mcap", colour=(noise, "rgb8"), times=np.arange(400) / 30)
    whole = len(list(open_recording(path).frames()))
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 3 // 4])
    with pytest.raises(FileError, match=r"is damaged: cut at byte .*imitate observe FILE --salvage"):
        open_recording(path)
    opened = open_recording(path, Perception(salvage=True))
    assert 100 < len(list(opened.frames())) < whole == 400
    assert any("used as far as it can be read" in note for note in opened.notes)


@pytest.mark.skipif(not FOREIGN.exists(), reason="the shared bags are not here")
@pytest.mark.parametrize("name", ["talker", "cdr_test_0", "only_services", "wrong_rmw_test_0"])
def test_bags_without_pictures(name):
    with pytest.raises(
        FileError, match=r"has no colour pictures; it has /.*Looked for 8-bit pictures in messages of"
    ):
        open_recording(FOREIGN / f"{name}.mcap")


def test_a_bags_folder_says_which_file(tmp_path):
    write(tmp_path / "bag_0.mcap")
    with pytest.raises(
        FileError, match=r"is a folder with bag_0.mcap. Name the file inside it: .*bag_0.mcap"
    ):
        open_recording(tmp_path)


def seen_points():
    """(H·W, 3) of the camera, NaN where nothing was read."""
    depth = np.where(METRES > 0, METRES, np.nan)
    return (CAMERA.rays() * depth[..., None]).reshape(-1, 3)


def test_organised_clouds_are_pictures(tmp_path):
    with bag(tmp_path / "bag.mcap") as made:
        made.transform("/tf_static", "world", "camera", [0.0, 0, 1, 0, 0, 0, 1])
        for k in range(3):
            made.cloud("/points", seen_points(), COLOUR.reshape(-1, 3), k / 10, height=48)
    assert kind_of(tmp_path / "bag.mcap") == "recording"
    opened = open_recording(tmp_path / "bag.mcap")
    found, real = opened.intrinsics, CAMERA
    assert (found.width, found.height) == (64, 48)
    assert [found.fx, found.fy, found.cx, found.cy] == pytest.approx([60, 60, real.cx, real.cy], abs=1e-3)
    frames = list(opened.frames())
    assert [frame.t for frame in frames] == pytest.approx([0, 0.1, 0.2])
    np.testing.assert_allclose(frames[0].depth, METRES, atol=1e-6)
    np.testing.assert_array_equal(frames[0].colour, COLOUR)


def test_clouds_of_a_sensor_that_looks_along_x_are_turned_and_it_is_said(tmp_path):
    with bag(tmp_path / "body.mcap") as made:
        for k in range(2):
            made.cloud(
                "/points", seen_points()[:, [2, 0, 1]] * [1, -1, -1], COLOUR.reshape(-1, 3), k / 10, height=48
            )
    opened = open_recording(tmp_path / "body.mcap")
    np.testing.assert_allclose(next(opened.frames()).depth, METRES, atol=1e-6)
    assert opened.notes == [
        "/points: its frame is taken as that of the sensor, x forward, y left, z up",
        "/points has no stamps: the log's times are used",
    ]


def test_clouds_that_are_no_pictures(tmp_path):
    with bag(tmp_path / "flat.mcap") as made:
        made.cloud("/points", seen_points(), COLOUR.reshape(-1, 3))
    with pytest.raises(FileError, match=r"/points holds clouds without colour, or whose points are not in"):
        open_recording(tmp_path / "flat.mcap")
    with bag(tmp_path / "bent.mcap") as made:
        made.cloud("/points", seen_points() ** 2, COLOUR.reshape(-1, 3), height=48)
    with pytest.raises(FileError, match=r"no camera at their origin sees, however it looks"):
        open_recording(tmp_path / "bent.mcap")
    with bag(tmp_path / "mm.mcap") as made:
        made.cloud("/points", 1000 * seen_points(), COLOUR.reshape(-1, 3), height=48)
    with pytest.raises(FileError, match=r"/points holds depths in an unknown unit.*--depth-unit 0.001"):
        open_recording(tmp_path / "mm.mcap")
    opened = open_recording(tmp_path / "mm.mcap", Perception(depth_unit=0.001))
    np.testing.assert_allclose(next(opened.frames()).depth, METRES, atol=1e-5)
