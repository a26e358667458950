"""The camera above the table: frames to pixels in the table's frame, and windows around places on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, conjugate, rotate
from imitate.perception.colour import hues
from imitate.perception.first_view import Table
from imitate.perception.shapes import Float, Pixels
from imitate.rgbd import Intrinsics, RgbdFrame


@dataclass(frozen=True)
class Eye:
    """A camera that knows where the table is.

    Attributes:
        table_from_camera: (7,).
        rays: (H·W, 3) in the table's frame, row by row; times the depth, from the camera to the point seen.
    """

    intrinsics: Intrinsics
    table_from_camera: Array
    rays: Float

    def pixels(self, frame: RgbdFrame) -> Pixels:
        """Every pixel of a frame, row by row."""
        hue = hues(frame.colour).reshape(-1)
        return Pixels(self.table_from_camera[:3], self.rays, frame.depth.reshape(-1), hue)

    def window(self, points: Array, margin: float, most: int) -> NDArray[np.intp]:
        """Indices of the pixels that show the space around points (N, 3), thinned out evenly to ``most``.

        Args:
            points: in the table's frame, metres.
            margin: metres around them.
            most: pixels.
        """
        i = self.intrinsics
        seen = rotate(conjugate(self.table_from_camera[3:]), points - self.table_from_camera[:3])
        depth = np.maximum(seen[:, 2], 0.1)
        u, v = i.fx * seen[:, 0] / depth + i.cx, i.fy * seen[:, 1] / depth + i.cy
        reach = margin * i.fx / depth
        left, right = _span(u - reach, u + reach, i.width)
        upper, lower = _span(v - reach, v + reach, i.height)
        step = max(1, int(np.ceil(np.sqrt((right - left) * (lower - upper) / most))))
        rows, columns = np.arange(upper, lower, step), np.arange(left, right, step)
        return np.asarray((rows[:, None] * i.width + columns).reshape(-1))


def open_eye(intrinsics: Intrinsics, table: Table) -> Eye:
    """The eye of a camera that saw this table."""
    turned = rotate(table.table_from_camera[3:], intrinsics.rays().reshape(-1, 3)).astype(np.float32)
    return Eye(intrinsics, table.table_from_camera, turned)


def _span(low: Array, high: Array, size: int) -> tuple[int, int]:
    first = int(np.clip(np.floor(low.min()), 0, size - 2))
    return first, int(np.clip(np.ceil(high.max()) + 1, first + 1, size))
