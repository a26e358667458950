"""Clouds of any frame are given in the camera's: found by where the points lie, by VIEWPOINT, or as told."""

import numpy as np
import pytest

from imitate.errors import FileError
from imitate.formats.clouds import read_cloud
from imitate.geometry import compose, inverse, rotate
from imitate.rgbd import Intrinsics

GRAPHICS, BODY = np.array([0, 0, 0, 1.0, 0, 0, 0]), np.array([0, 0, 0, -0.5, 0.5, -0.5, 0.5])
KINECT = np.array([0, 0, 0, 0, 0, 1.0, 0])
AT = np.array([0.3, -0.2, 1.4, 0.6, -0.6, 0.36, -0.3861])
AT[3:] /= np.linalg.norm(AT[3:])
SHAPE = (24, 32)


def seen():
    """(N, 3) a slope with a step in it, of 32 × 24 pixels; one is not read."""
    rays = Intrinsics(32, 24, 26, 26, 15.5, 11.5).rays()
    depth = 1 + 0.3 * rays[..., 1] + 0.1 * (rays[..., 0] > 0.2)
    points = (rays * depth[..., None]).reshape(-1, 3)
    points[5] = np.nan
    return points


def write(path, points, shape=SHAPE, viewpoint=None):
    pose = [0, 0, 0, 0, 0, 0, 1] if viewpoint is None else viewpoint
    numbers = " ".join(f"{value:.9g}" for value in [*pose[:3], pose[6], *pose[3:6]])
    header = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    header += f"WIDTH {shape[1]}\nHEIGHT {shape[0]}\nVIEWPOINT {numbers}\nPOINTS {len(points)}\n"
    path.write_bytes(header.encode() + b"DATA binary\n" + points.astype("<f4").tobytes())
    return path


def given(cloud_from_camera, points):
    return cloud_from_camera[:3] + rotate(cloud_from_camera[3:], points)


@pytest.mark.parametrize("ordered", [True, False])
@pytest.mark.parametrize(
    ("frame", "viewpoint", "words"),
    [
        (GRAPHICS, None, "of the sensor, x right, y up, z towards the sensor"),
        (GRAPHICS, GRAPHICS, "of the sensor, x right, y up, z towards the sensor"),
        (BODY, None, "of the sensor, x forward, y left, z up"),
        (AT, AT, "of a world, seen from VIEWPOINT (x right, y down, z forward)"),
        (AT, compose(AT, inverse(BODY)), "of a world, seen from VIEWPOINT (x forward, y left, z up)"),
    ],
)
def test_the_frame_is_found_and_said(tmp_path, frame, viewpoint, words, ordered):
    shape = SHAPE if ordered else (1, SHAPE[0] * SHAPE[1])
    cloud = read_cloud(write(tmp_path / "cloud.pcd", given(frame, seen()), shape, viewpoint))
    np.testing.assert_allclose(cloud.points, seen(), atol=1e-5)
    np.testing.assert_allclose(given(cloud.cloud_from_camera, seen()), given(frame, seen()), atol=1e-5)
    assert cloud.notes == (f"its frame is taken as that {words}; --sensor says otherwise",)


def test_a_picture_tells_any_axes(tmp_path):
    cloud = read_cloud(write(tmp_path / "cloud.pcd", given(KINECT, seen())))
    np.testing.assert_allclose(cloud.points, seen(), atol=1e-5)
    (note,) = cloud.notes
    assert "x left, y up, z forward" in note


@pytest.mark.parametrize("viewpoint", [None, AT])
def test_points_of_the_camera_stay_whatever_the_viewpoint(tmp_path, viewpoint):
    cloud = read_cloud(write(tmp_path / "cloud.pcd", seen(), viewpoint=viewpoint))
    np.testing.assert_allclose(cloud.points, seen(), atol=1e-6)
    assert cloud.notes == ()


def test_the_frame_can_be_told(tmp_path):
    path = write(tmp_path / "cloud.pcd", given(AT, seen()))
    assert read_cloud(path).notes[-1] == (
        "no camera there sees each point in its own pixel; --sensor says where it is"
    )
    told = read_cloud(path, sensor=",".join(map(str, AT)))
    np.testing.assert_allclose(told.points, seen(), atol=1e-5)
    assert told.notes == (
        "its frame is taken as that in which you place the camera; --sensor says otherwise",
    )
    body = write(tmp_path / "body.pcd", given(BODY, seen()))
    np.testing.assert_allclose(read_cloud(body, sensor="body").points, seen(), atol=1e-5)


def test_a_viewpoint_that_the_file_has_not(tmp_path):
    with pytest.raises(
        FileError, match=r"says nothing of a viewpoint. Expected optical, graphics, body, viewp"
    ):
        read_cloud(write(tmp_path / "cloud.pcd", seen()), sensor="viewpoint")
