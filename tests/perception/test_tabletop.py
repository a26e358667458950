"""Table and clusters in real Kinect scenes; open3d missing is said in test_observe."""

from pathlib import Path

import numpy as np
import pytest

from imitate.errors import ImitateError
from imitate.geometry import inverse, rotate
from imitate.perception.tabletop import ABOVE, PLANE, clusters, find_table, open3d

SCENES = Path(__file__).parents[3] / "shared" / "data" / "tabletop"


def scene(name):
    """(points (N, 3), labels (N,)) with a reading; label 1–9 table, else object = label // 10."""
    path = SCENES / f"mosd_{name}.pcd"
    if not path.exists():
        pytest.skip("needs ../shared/data/tabletop, real scenes that are not ours to copy")
    cloud = open3d().t.io.read_point_cloud(str(path))
    points, labels = cloud.point.positions.numpy().astype(float), cloud.point["label"].numpy().ravel()
    read = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
    return points[read], labels[read].astype(int)


@pytest.mark.parametrize("name", ["learn0", "learn1", "learn5", "learn10"])
def test_real_boxes_apart(name):
    points, labels = scene(name)
    table_from_camera = find_table(points, seed=0)
    placed = table_from_camera[:3] + rotate(table_from_camera[3:], points)
    table = (labels >= 1) & (labels <= 9)
    assert np.median(np.abs(placed[table, 2])) < 0.002
    low, high = np.percentile(placed[np.abs(placed[:, 2]) < PLANE], [0.5, 99.5], axis=0)[:, :2]
    over = np.all((placed[:, :2] > low) & (placed[:, :2] < high), axis=1) & (placed[:, 2] < 0.5)
    found = clusters(placed, over)
    real = sorted(set(labels[labels >= 10] // 10))
    assert sorted(np.bincount(labels[k] // 10).argmax() for k in found) == real
    for indices in found:
        counts = np.bincount(labels[indices] // 10)
        assert counts.max() / len(indices) > 0.95
        assert counts.max() / np.sum(labels // 10 == counts.argmax()) > 0.8


def test_frame_is_right_handed_with_z_up_and_x_away():
    generator = np.random.default_rng(0)
    flat = np.stack([generator.uniform(-0.4, 0.4, 5000), generator.uniform(-0.3, 0.3, 5000)], axis=1)
    tilt = np.array([np.sin(1.0), 0, 0, np.cos(1.0)])  # a camera that looks forward and down
    points = np.array([0, 0, 0.9]) + rotate(tilt, np.column_stack([flat, np.zeros(5000)]))
    camera_from_table = inverse(find_table(points, seed=0))
    np.testing.assert_allclose(camera_from_table[:3], [0, 0, 0.9], atol=0.01)
    x, y, z = (rotate(camera_from_table[3:], axis) for axis in np.eye(3))
    assert x[2] > 0 and y[0] < -0.99 and z[1] < 0
    np.testing.assert_allclose(np.cross(x, y), z, atol=1e-9)


def test_clusters_ignore_the_table_itself():
    generator = np.random.default_rng(1)
    table = np.column_stack([generator.uniform(-0.3, 0.3, (4000, 2)), generator.normal(0, 0.002, 4000)])
    things = [
        np.array([x, 0, 0]) + generator.uniform(0, 0.04, (900, 3)) + [0, 0, ABOVE] for x in (-0.1, 0, 0.1)
    ]
    found = clusters(np.concatenate([table, *things]), np.ones(4000 + 2700, bool))
    assert sorted(len(set((k - 4000) // 900)) for k in found) == [1, 1, 1]


def test_too_few_readings():
    with pytest.raises(ImitateError, match="only 10 pixels have a depth"):
        find_table(np.zeros((10, 3)), seed=0)
