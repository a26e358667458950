"""Points thinned to a grid, and the parts of a cloud that hang together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from imitate.errors import ImitateError
from imitate.geometry import Array

_END = 2**20
"""cells from the middle of a grid to its end: three such numbers fit into one of 64 bits."""


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


def dense_parts(points: Array, apart: float, fewest: int) -> list[NDArray[np.intp]]:
    """Indices of the points (N, 3) of each part that is ``apart`` metres from the others, the largest first.

    Points with less than ``fewest`` neighbours, themselves included, are in none (DBSCAN, Ester et al. 1996).
    """
    o3d = open3d()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    labels = np.asarray(cloud.cluster_dbscan(apart, fewest))
    counts = np.bincount(labels[labels >= 0]) if (labels >= 0).any() else np.zeros(0, int)
    return [np.flatnonzero(labels == k) for k in np.argsort(-counts, kind="stable")]


def thinned(points: Array, size: float) -> Array:
    """(M, 3) the mean of the points (N, 3) in each cell of a grid of ``size`` metres, in the cells' order."""
    x, y, z = np.clip(np.floor(points.T / size), -_END, _END - 1).astype(np.int64) + _END
    _, inside = np.unique((x * 2 * _END + y) * 2 * _END + z, return_inverse=True)
    counts = np.bincount(inside)
    return np.stack([np.bincount(inside, points[:, k]) / counts for k in range(3)], axis=1)
