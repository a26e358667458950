"""The table in made-up views: frame, which of several planes it is. Without open3d: test_observe."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imitate.errors import ImitateError
from imitate.geometry import inverse, rotate
from imitate.perception.noise import BEST, kinect_noise, scatter
from imitate.perception.tabletop import find_table


def seen(surfaces, pitch, roll=0.0, height=0.7, seed=0):
    """Points (N, 3) of a 160×120 camera that looks at the origin from ``height`` m, with a Kinect's noise.

    ``surfaces`` are (corner, edge, edge) parallelograms in a frame with z up.
    """
    right, forward = np.array([0, -1.0, 0]), np.array([np.cos(pitch), 0, -np.sin(pitch)])
    level = Rotation.from_matrix(np.stack([right, np.cross(forward, right), forward], axis=1))
    from_camera = level * Rotation.from_euler("z", roll)
    eye = -from_camera.apply([0, 0, 1.0]) * height
    u, v = np.meshgrid(np.arange(160), np.arange(120))
    rays = np.stack([(u - 79.5) / 131, (v - 59.5) / 131, np.ones_like(u)], axis=-1).reshape(-1, 3)
    steps = from_camera.apply(rays)
    depth = np.full(len(rays), np.inf)
    for corner, a, b in surfaces:
        solved = np.linalg.solve(
            np.stack([np.broadcast_to(a, steps.shape), np.broadcast_to(b, steps.shape), -steps], axis=-1),
            np.broadcast_to(eye - corner, steps.shape)[..., None],
        )[..., 0]
        hit = np.all((solved[:, :2] >= 0) & (solved[:, :2] <= 1), axis=1) & (solved[:, 2] > 0)
        depth = np.where(hit, np.minimum(depth, solved[:, 2]), depth)
    kept = np.isfinite(depth)
    rays, depth = rays[kept], depth[kept]
    depth += kinect_noise(depth) * np.random.default_rng(seed).standard_normal(len(depth))
    return rays * depth[:, None], from_camera, eye


def box(x, y, size, z=0.0):
    a, b, c = np.diag(size).astype(float)
    low = np.array([x, y, z]) - [size[0] / 2, size[1] / 2, 0]
    return [(low, a, b), (low + c, a, b), (low, a, c), (low + b, a, c), (low, b, c), (low + a, b, c)]


def flat(width, depth, x=0.0, y=0.0, z=0.0):
    return [
        (np.array([x - width / 2, y - depth / 2, z]), np.array([width, 0, 0.0]), np.array([0, depth, 0.0]))
    ]


WALL = [(np.array([0.35, -2, -0.7]), np.array([0, 4.0, 0]), np.array([0, 0, 2.5]))]
FLOOR = flat(6, 6, z=-0.7)
THINGS = box(-0.05, 0.08, (0.04, 0.06, 0.05)) + box(0.05, -0.08, (0.05, 0.05, 0.05))


def is_the_table(found, from_camera, eye):
    """Whether a table is the plane z = 0, facing up."""
    normal = from_camera.as_matrix() @ found.plane[:3]
    return normal[2] > np.cos(np.deg2rad(1.5)) and abs(found.plane[3] - eye[2]) < 0.005


@pytest.mark.parametrize("pitch", [30, 45, 70])
@pytest.mark.parametrize("roll", [0, 25, -90])
@pytest.mark.parametrize("around", ["floor", "wall"])
def test_a_small_table_with_things_before_larger_planes(pitch, roll, around):
    surfaces = flat(0.4, 0.5) + THINGS + (FLOOR if around == "floor" else WALL)
    points, from_camera, eye = seen(surfaces, np.deg2rad(pitch), np.deg2rad(roll), height=1.0)
    assert is_the_table(find_table(points, seed=0), from_camera, eye)


@pytest.mark.parametrize("pitch", [35, 55])
def test_a_box_whose_side_faces_the_whole_small_table_is_not_what_carries_it(pitch):
    surfaces = flat(0.35, 0.4) + box(0.08, 0, (0.06, 0.2, 0.27))
    points, from_camera, eye = seen(surfaces, np.deg2rad(pitch))
    assert is_the_table(find_table(points, seed=0), from_camera, eye)


def test_without_things_the_largest_plane_is_the_table():
    points, from_camera, eye = seen(flat(1.2, 1.0) + WALL, np.deg2rad(50))
    assert is_the_table(find_table(points, seed=0), from_camera, eye)


def cluttered(seed=0):
    """A table with a crowd of boxes of like heights, so that a plane through their tops carries more."""
    generator = np.random.default_rng(seed)
    things = [
        part
        for x in np.arange(-0.3, 0.31, 0.1)
        for y in np.arange(-0.3, 0.31, 0.1)
        for part in box(x, y, (*generator.uniform(0.05, 0.07, 2), generator.uniform(0.05, 0.1)))
    ]
    return seen(flat(1.0, 1.0) + things, np.deg2rad(40), height=1.2, seed=seed)


@pytest.mark.parametrize("seed", range(3))
def test_a_plane_that_cuts_through_things_is_seen_through(seed):
    points, from_camera, eye = cluttered(seed)
    found = find_table(points, seed)
    assert is_the_table(found, from_camera, eye) and found.doubt == ""


def test_what_is_seen_through_is_doubted_where_there_is_no_other():
    generator = np.random.default_rng(0)
    points, _, _ = seen(flat(0.5, 0.5), np.deg2rad(50), seed=1)
    far = points[generator.random(len(points)) < 0.5] * generator.uniform(1.2, 1.6, (1, 1))
    veil = points[generator.random(len(points)) < 0.5]
    behind = far * generator.uniform(1, 1.5, (len(far), 1))
    found = find_table(np.concatenate([veil, behind]), seed=0)
    assert "it cuts through things: as much is seen through it as" in found.doubt


HASH = """
import hashlib, sys
import numpy as np
from imitate.perception.tabletop import find_table
table = find_table(np.load(sys.argv[1]), 3)
parts = (table.plane, table.outline, table.table_from_camera)
print(hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest())
"""


def bits(table):
    parts = (table.plane, table.outline, table.table_from_camera)
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


def test_a_cluttered_view_gives_the_same_bits_eight_times_and_in_another_process(tmp_path):
    points, _, _ = cluttered()
    found = {bits(find_table(points, 3)) for _ in range(8)}
    np.save(tmp_path / "points.npy", points)
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    run = subprocess.run(
        [sys.executable, "-c", HASH, str(tmp_path / "points.npy")],
        env=os.environ | threads,
        capture_output=True,
        text=True,
        check=True,
    )
    assert found == {run.stdout.strip()}


def test_frame_is_right_handed_with_z_up_and_x_away():
    points, _, _ = seen(flat(0.4, 0.4), np.deg2rad(57))
    camera_from_table = inverse(find_table(points, seed=0).table_from_camera)
    np.testing.assert_allclose(camera_from_table[:3], [0, 0, 0.7], atol=0.01)
    x, y, z = (rotate(camera_from_table[3:], axis) for axis in np.eye(3))
    assert x[2] > 0 and y[0] < -0.99 and z[1] < 0
    np.testing.assert_allclose(np.cross(x, y), z, atol=1e-9)


def test_outline_holds_the_tabletop_and_no_more():
    points, _, _ = seen(flat(0.4, 0.5), np.deg2rad(50))
    table = find_table(points, seed=0)
    assert table.reaches(np.array([[0.19, 0.24, 0], [-0.19, -0.24, 0.1]])).all()
    assert not table.reaches(np.array([[0.3, 0, 0], [0, -0.4, 0], [0.26, 0.3, 0]])).any()


def test_noise_is_measured_as_a_multiple_of_a_kinects():
    generator = np.random.default_rng(0)
    depth = generator.uniform(0.5, 2, 20000)
    for times in (0.5, 1.0, 2.5):
        residuals = times * kinect_noise(depth) * generator.standard_normal(20000)
        residuals[:4000] += 0.3  # something else
        assert scatter(residuals, depth) == pytest.approx(times, rel=0.35)
    assert scatter(np.zeros(10), np.ones(10)) == BEST


def test_too_few_readings():
    with pytest.raises(ImitateError, match="only 10 pixels have a depth"):
        find_table(np.zeros((10, 3)), seed=0)


def test_no_plane():
    with pytest.raises(ImitateError, match="no table"):
        find_table(np.random.default_rng(0).uniform([-1, -1, 1], [1, 1, 3], (3000, 3)), seed=0)
