"""The tabletop in the first view: dominant plane, table frame, and clusters of what stands on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from imitate.errors import ImitateError
from imitate.geometry import Array, inverse

PLANE = 0.008
"""m from the plane within which a point lies on it: several standard deviations of a Kinect below 1 m."""
VOXEL = 0.004
"""m, the grid on which points are clustered."""
ABOVE = 0.012
"""m above the table from which a point belongs to something standing on it."""
APART = 0.015
"""m between the nearest points of two objects."""
FEWEST = 30
"""occupied voxels of the smallest object."""


def open3d() -> Any:
    """The open3d module.

    Raises:
        ImitateError: it cannot be imported; the message holds the line that installs what it lacks.
    """
    try:
        import open3d as module
    except (ImportError, OSError) as error:
        raise ImitateError(
            f"open3d, which finds the table, cannot be imported ({error}). This installs what it needs: "
            "python -m pip install 'open3d-cpu==0.19.*' && "
            "sudo apt-get install -y libgl1 libgomp1 libx11-6 libusb-1.0-0"
        ) from None
    return module


def find_table(points: Array, seed: int) -> Array:
    """(7,) table_from_camera: z up, z = 0 on the table, the origin in the middle of its visible top.

    x points away from the camera along the table, so y points to the camera's left.

    Args:
        points: (N, 3) in the camera's frame (x right, y down, z forward), metres.
        seed: of RANSAC.

    Raises:
        ImitateError: no plane that could be a table.
    """
    o3d = open3d()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    o3d.utility.random.seed(seed)
    if len(points) < 1000:
        raise ImitateError(f"only {len(points)} pixels have a depth; a table cannot be found in them.")
    _, inliers = cloud.segment_plane(PLANE, 3, 1000)
    normal, offset = _plane_through(points[inliers])
    near = np.abs(points @ normal + offset) < PLANE
    normal, offset = _plane_through(points[near])
    top = _largest_cluster(points[near])
    ahead = np.array([0, -1.0, 1.0])  # into the picture: forward where it looks along, up where it looks down
    x = ahead - normal * (normal @ ahead)
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(normal, x), normal], axis=1)
    middle = (top @ axes).min(axis=0) / 2 + (top @ axes).max(axis=0) / 2
    middle[2] = -offset
    camera_from_table = np.concatenate([axes @ middle, Rotation.from_matrix(axes).as_quat()])
    return inverse(camera_from_table)


def clusters(points: Array, within: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Indices of the points of each object on the table, the largest first.

    Args:
        points: (N, 3) in the table's frame.
        within: (N,) whether a point may belong to an object at all.
    """
    o3d = open3d()
    candidates = np.flatnonzero(within & (points[:, 2] > ABOVE))
    if not len(candidates):
        return []
    voxels, inside = np.unique(np.floor(points[candidates] / VOXEL), axis=0, return_inverse=True)
    grid = o3d.geometry.PointCloud(o3d.utility.Vector3dVector((voxels + 0.5) * VOXEL))
    labels = np.asarray(grid.cluster_dbscan(APART, 5))
    counts = np.bincount(labels[labels >= 0]) if (labels >= 0).any() else np.zeros(0, int)
    large = [k for k in np.argsort(-counts, kind="stable") if counts[k] >= FEWEST]
    return [candidates[labels[inside] == k] for k in large]


def _plane_through(points: Array) -> tuple[Array, float]:
    """Normal towards the camera and offset of the least-squares plane n·p + d = 0."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd((points - middle).T @ (points - middle))[0][:, 2]
    normal = normal if normal @ middle < 0 else -normal
    return normal, float(-normal @ middle)


def _largest_cluster(points: Array) -> Array:
    """The points of the largest connected part, on a grid of 2 cm."""
    o3d = open3d()
    voxels, inside = np.unique(np.floor(points / 0.02), axis=0, return_inverse=True)
    grid = o3d.geometry.PointCloud(o3d.utility.Vector3dVector((voxels + 0.5) * 0.02))
    labels = np.asarray(grid.cluster_dbscan(0.05, 4))
    kept = labels == np.bincount(labels[labels >= 0]).argmax()
    return np.asarray(points[kept[inside]])
