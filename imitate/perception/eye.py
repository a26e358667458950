"""The camera above the table: windows of a frame as pixels in the table's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imitate.geometry import Array, conjugate, rotate
from imitate.perception.colour import hues
from imitate.perception.fingers import FingerColours
from imitate.perception.shapes import Float, Mask, Pixels
from imitate.perception.tabletop import ROOM, Table
from imitate.rgbd import Intrinsics, RgbdFrame

Window = tuple[slice, slice]
"""rows and columns of a picture."""


@dataclass(frozen=True)
class Eye:
    """A camera that knows where the table is.

    Attributes:
        table_from_camera: (7,).
        rays: (H, W, 3) in the table's frame; times the depth, from the camera to the point seen.
        low, high: (2,) the table's extent in x and y, metres.
        fingers: their colours; None where no hand is in view.
    """

    intrinsics: Intrinsics
    table_from_camera: Array
    rays: Float
    low: Array
    high: Array
    fingers: FingerColours | None

    def is_over_table(self, points: Array) -> Mask:
        """(N,) which points (N, 3) in the table's frame are over the table, at most `ROOM` above it."""
        inside = np.all((points[:, :2] > self.low) & (points[:, :2] < self.high), axis=1)
        return np.asarray(inside & (points[:, 2] < ROOM))

    def window(self, points: Array, margin: float, most: int, phase: int = 0) -> Window:
        """The pixels that show the space around points (N, 3), thinned out evenly to about ``most``.

        Args:
            points: in the table's frame, metres.
            margin: metres around them.
            most: pixels.
            phase: shifts the grid that is left, so that frames with other phases see other pixels.
        """
        i = self.intrinsics
        seen = rotate(conjugate(self.table_from_camera[3:]), points - self.table_from_camera[:3])
        depth = np.maximum(seen[:, 2], 0.1)
        u, v = i.fx * seen[:, 0] / depth + i.cx, i.fy * seen[:, 1] / depth + i.cy
        reach = margin * i.fx / depth
        left, right = _span(u - reach, u + reach, i.width)
        upper, lower = _span(v - reach, v + reach, i.height)
        step = max(1, int(np.ceil(np.sqrt((right - left) * (lower - upper) / most))))
        down, across = divmod(phase % step**2, step)
        return slice(upper + down, lower, step), slice(left + across, right, step)


@dataclass(frozen=True)
class View:
    """One frame as the eye sees it; ``number`` counts the frames."""

    eye: Eye
    frame: RgbdFrame
    number: int

    def pixels(self, window: Window) -> Pixels:
        """The pixels of a window, row by row."""
        eye, colour = self.eye, self.frame.colour[window]
        hue = (eye.fingers.hues(colour) if eye.fingers else hues(colour)).reshape(-1)
        rays = eye.rays[window].reshape(-1, 3)
        return Pixels(eye.table_from_camera[:3], rays, self.frame.depth[window].reshape(-1), hue)

    def everything(self) -> Array:
        """(H·W, 3) the points shown, in the table's frame; the camera's place where nothing was read."""
        shown = self.eye.table_from_camera[:3] + self.eye.rays * self.frame.depth[..., None]
        return np.asarray(shown, float).reshape(-1, 3)

    def window(self, points: Array, margin: float) -> Window:
        """All pixels that show the space around points (N, 3) in the table's frame, ``margin`` metres."""
        return self.eye.window(points, margin, self.frame.depth.size)

    def around(self, points: Array, margin: float, most: int) -> Pixels:
        """The pixels that show the space around points, as of `Eye.window`."""
        return self.pixels(self.eye.window(points, margin, most, self.number))


def open_eye(intrinsics: Intrinsics, table: Table, fingers: FingerColours) -> Eye:
    """The eye of a camera that saw this table."""
    turned = rotate(table.table_from_camera[3:], intrinsics.rays()).astype(np.float32)
    return Eye(intrinsics, table.table_from_camera, turned, table.low, table.high, fingers)


def _span(low: Array, high: Array, size: int) -> tuple[int, int]:
    first = int(np.clip(np.floor(low.min()), 0, size - 2))
    return first, int(np.clip(np.ceil(high.max()) + 1, first + 1, size))
