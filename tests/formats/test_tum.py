"""Folders in the layout of the TUM RGB-D benchmark: read, calibrated from a file or by hand, and refused."""

import cv2
import numpy as np
import pytest

from imitate.errors import FileError
from imitate.formats.kind import kind_of
from imitate.formats.recordings import open_recording
from imitate.rgbd import Intrinsics
from imitate.settings import Perception

CAMERA = Intrinsics(64, 48, 52.5, 52.5, 31.5, 23.5)
STEPS = np.random.default_rng(0).integers(3000, 7000, (48, 64)).astype(np.uint16)
STEPS[:4] = 0


@pytest.fixture
def folder(tmp_path):
    """Five colour and five depth pictures; the third depth has no colour near it."""
    lines = {"rgb": ["# color images", "# file: 'made up'"], "depth": ["# depth maps"]}
    for name in lines:
        (tmp_path / name).mkdir()
    for k in range(5):
        at = 1305031102.1753 + k / 30
        late = at + (0.5 if k == 2 else 0.004)
        colour = np.full((48, 64, 3), (30, 20 * k, 200), np.uint8)
        for name, t, pixels in (("rgb", late, colour), ("depth", at, STEPS + np.uint16(k) * (STEPS > 0))):
            file = f"{name}/{t:.6f}.png"
            assert cv2.imwrite(str(tmp_path / file), pixels)
            lines[name].append(f"{t:.6f} {file}")
    for name, rows in lines.items():
        (tmp_path / f"{name}.txt").write_text("\n".join(rows) + "\n")
    (tmp_path / "calibration.txt").write_text("# fx fy cx cy\n52.5 52.5 31.5 23.5\n")
    return tmp_path


def test_frames_of_a_folder(folder):
    assert kind_of(folder) == "recording"
    opened = open_recording(folder)
    assert (opened.intrinsics, opened.count) == (CAMERA, 5)
    frames = list(opened.frames())
    assert [frame.t for frame in frames] == pytest.approx([0, 1 / 30, 3 / 30, 4 / 30], abs=2e-6)
    for k, frame in zip((0, 1, 3, 4), frames, strict=True):
        assert (frame.colour == (200, 20 * k, 30)).all()
        np.testing.assert_allclose(frame.depth, (STEPS + k * (STEPS > 0)) / 5000, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("camera.txt", "52.5, 52.5, 31.5, 23.5"),
        ("intrinsics.txt", "52.5 0 31.5\n0 52.5 23.5\n0 0 1\n"),
        ("calibration.txt", "52.5 52.5 31.5 23.5 0 0 0 0 0"),
    ],
)
def test_calibration_files(folder, name, text):
    (folder / "calibration.txt").unlink()
    (folder / name).write_text(text)
    opened = open_recording(folder)
    assert opened.intrinsics == CAMERA
    assert len(list(opened.frames())) == 4


def test_settings_go_before_what_the_folder_says(folder):
    opened = open_recording(folder, Perception(intrinsics=(50, 51, 32, 24), depth_unit=0.001))
    assert opened.intrinsics == Intrinsics(64, 48, 50, 51, 32, 24)
    np.testing.assert_allclose(next(opened.frames()).depth, STEPS / 1000, atol=1e-6)


def test_without_a_calibration_it_says_what_to_pass(folder):
    (folder / "calibration.txt").unlink()
    words = (
        r"has no calibration of its camera: looked for calibration.txt, .*--intrinsics FX,FY,CX,CY \(525,525"
    )
    with pytest.raises(FileError, match=words):
        open_recording(folder)
    (folder / "camera.txt").write_text("Kinect 1")
    with pytest.raises(FileError, match=r"camera.txt: holds 'Kinect 1', not fx fy cx cy"):
        open_recording(folder)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: (f / "depth.txt").write_text("# nothing\n"), r"depth.txt: lists no picture"),
        (lambda f: (f / "rgb.txt").write_text("soon rgb/1.png\n"), r"rgb.txt: line 1 is 'soon rgb/1.png'"),
        (lambda f: (f / "rgb.txt").write_text("1.5\n"), r"rgb.txt: line 1 is '1.5'"),
        (
            lambda f: (f / "rgb.txt").write_text("1305031102.18 rgb/none.png\n"),
            r"none.png: is listed but cannot",
        ),
        (lambda f: (f / "depth.txt").unlink(), r"is a folder without depth.txt"),
        (
            lambda f: cv2.imwrite(str(next((f / "depth").iterdir())), np.zeros((48, 64, 3), np.uint8)),
            "as depth",
        ),
        (lambda f: cv2.imwrite(str(min((f / "depth").iterdir())), STEPS[:24]), "its calibration says 64×48"),
    ],
)
def test_what_is_wrong_with_a_folder(folder, change, words):
    change(folder)
    with pytest.raises(FileError, match=words):
        list(open_recording(folder).frames())


def test_lists_that_share_no_moment(folder):
    text = (folder / "rgb.txt").read_text()
    (folder / "rgb.txt").write_text(text.replace("\n1305", "\n1405"))
    with pytest.raises(
        FileError, match=r"never pair within 0.04 s: 5 pictures in rgb.txt, 5 in depth.txt; the"
    ):
        list(open_recording(folder).frames())
