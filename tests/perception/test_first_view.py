"""The first view: table, objects and labels in real Kinect scenes and in synthetic clouds."""

from pathlib import Path

import numpy as np
import pytest

from imitate.perception.first_view import first_view
from imitate.perception.tabletop import open3d
from imitate.settings import Perception

SCENES = Path(__file__).parents[3] / "shared" / "data" / "tabletop"


def scene(name):
    """(points (N, 3), colour (N, 3), labels (N,)) row by row; label 1–9 table, else object = label // 10."""
    path = SCENES / f"mosd_{name}.pcd"
    if not path.exists():
        pytest.skip("needs ../shared/data/tabletop, real scenes that are not ours to copy")
    cloud = open3d().t.io.read_point_cloud(str(path))
    points, labels = cloud.point.positions.numpy().astype(float), cloud.point["label"].numpy().ravel()
    return points, cloud.point["colors"].numpy(), labels.astype(int)


def overlap(seen, labels):
    """Mean over the real objects of the best intersection over union with a found one."""
    real = [labels // 10 == k for k in sorted(set(labels[labels >= 10] // 10))]
    found = [seen.labels == k + 1 for k in range(len(seen.objects))]
    return np.mean([max(np.sum(r & f) / np.sum(r | f) for f in found) for r in real])


def labelled_plane(points, labels):
    """(normal, centroid) of the least-squares plane through the points labelled as table."""
    table = points[(labels >= 1) & (labels <= 9) & np.isfinite(points[:, 2])]
    middle = table.mean(axis=0)
    return np.linalg.svd((table - middle).T @ (table - middle))[0][:, 2], middle


@pytest.mark.parametrize("name", ["learn0", "learn1", "learn5", "learn10"])
@pytest.mark.parametrize("kind", ["picture", "colourless", "unordered"])
def test_real_boxes_apart(name, kind):
    points, colour, labels = scene(name)
    if kind == "picture":
        seen = first_view(points, colour, Perception(), 0, (480, 640))
    elif kind == "colourless":
        seen = first_view(points, None, Perception(), 0, (480, 640))
    else:
        order = np.random.default_rng(0).permutation(np.flatnonzero(np.isfinite(points[:, 2])))
        points, labels = points[order], labels[order]
        seen = first_view(points, colour[order], Perception(), 0)
    assert len(seen.objects) == len(set(labels[labels >= 10] // 10))
    assert overlap(seen, labels) > 0.95
    assert not any(thing.uncertain for thing in seen.objects)
    normal, middle = labelled_plane(points, labels)
    assert abs(seen.table.plane[:3] @ normal) > np.cos(np.deg2rad(0.1))
    assert abs(seen.table.plane[:3] @ middle + seen.table.plane[3]) < 0.001
    assert [thing.points for thing in seen.objects] == [
        np.sum(seen.labels == k + 1) for k in range(len(seen.objects))
    ]


@pytest.mark.parametrize("name", ["learn17", "learn18"])
def test_real_boxes_on_each_other_are_uncertain(name):
    points, colour, labels = scene(name)
    seen = first_view(points, colour, Perception(), 0, (480, 640))
    top = labels // 10 == labels[labels >= 10].min() // 10
    for k in {int(np.bincount(seen.labels[top] + 1).argmax()) - 1}:
        thing = seen.objects[k - 1]
        assert thing.uncertain and thing.reason, thing
