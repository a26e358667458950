"""Clouds whose points are a picture's pixels: the lens that took them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from imitate.rgbd import Intrinsics

_OFF = 0.5
"""pixels, the median distance of a point from its own pixel, beyond which no pinhole camera took a cloud."""


def fitted_intrinsics(points: NDArray[np.floating]) -> Intrinsics | None:
    """The pinhole camera that sees each of the points (H, W, 3) in its own pixel, by least squares.

    NaN or z = 0 where nothing was read. None where no camera at the origin, looking along z, does.
    """
    height, width = points.shape[:2]
    rows, columns = np.nonzero(np.isfinite(points).all(axis=2) & (points[..., 2] > 0))
    if len(rows) < 100:
        return None
    x, y, z = points[rows, columns].T.astype(float)
    found = []
    for pixel, slope in ((columns, x / z), (rows, y / z)):
        line = np.stack([slope, np.ones_like(slope)], axis=1)
        (focal, centre), *_ = np.linalg.lstsq(line, pixel.astype(float), rcond=None)
        if focal <= 1 or np.median(np.abs(line @ [focal, centre] - pixel)) > _OFF:
            return None
        found.append((float(focal), float(centre)))
    (fx, cx), (fy, cy) = found
    return Intrinsics(width, height, fx, fy, cx, cy)
