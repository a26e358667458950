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


@pytest.mark.parametrize("name", ["learn0", "learn1", "learn5", "learn10"])
@pytest.mark.parametrize("coloured", [True, False])
def test_real_boxes_apart(name, coloured):
    points, colour, labels = scene(name)
    seen = first_view(points, colour if coloured else None, Perception(), 0, (480, 640))
    assert seen.labels.shape == (len(points),)
    assert len(seen.objects) == len(set(labels[labels >= 10] // 10))
    for k, thing in enumerate(seen.objects):
        assert thing.points == np.sum(seen.labels == k + 1)
