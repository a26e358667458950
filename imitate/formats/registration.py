"""Two cameras made one: pictures without distortion, and colour looked up where each depth was read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, read_only, rotate
from imitate.rgbd import Intrinsics

_FISHEYE = ("equidistant", "fisheye", "kannala_brandt")
_POLYNOMIAL = ("", "plumb_bob", "rational_polynomial")
_COUNTS = (4, 5, 8, 12, 14)
"""of coefficients that OpenCV's polynomial models have."""
_HIDDEN = 0.02
"""m behind the nearest reading from which a point counts as hidden from the colour camera."""

Map = tuple[NDArray[Any], NDArray[Any]]


@dataclass(frozen=True)
class Lens:
    """A camera's intrinsics and distortion.

    Attributes:
        intrinsics: width and height 0 where the calibration does not say them.
        model: "plumb_bob" or "rational_polynomial" (OpenCV's k1 k2 p1 p2 k3 …), or "equidistant" (fisheye).
        coefficients: of the model; none, or all 0, for a picture without distortion.
    """

    intrinsics: Intrinsics
    model: str = ""
    coefficients: tuple[float, ...] = ()

    @property
    def straight(self) -> bool:
        """Whether straight lines stay straight."""
        return not any(self.coefficients)

    @property
    def known(self) -> bool:
        """Whether its distortion can be undone."""
        count = len(self.coefficients)
        fits = count == 4 if self.model in _FISHEYE else self.model in _POLYNOMIAL and count in _COUNTS
        return self.straight or fits

    def undistortion(self) -> Map:
        """For each pixel of the picture without distortion, where it is in the picture as taken."""
        i, coefficients = self.intrinsics, np.array(self.coefficients)
        k = np.array([[i.fx, 0, i.cx], [0, i.fy, i.cy], [0, 0, 1.0]])
        make: Any = cv2.fisheye if self.model in _FISHEYE else cv2
        size, still = (i.width, i.height), np.eye(3)
        u, v = make.initUndistortRectifyMap(k, coefficients, still, k, size, cv2.CV_32FC1)
        return np.asarray(u), np.asarray(v)


@dataclass(frozen=True)
class Registration:
    """Colour and depth of one camera, or of two beside each other, as pictures of the depth camera.

    Attributes:
        colour, depth: the lenses as the pictures were taken.
        colour_from_depth: (7,) the depth camera's frame in the colour camera's, metres; None where both
            pictures are already those of one camera.

    The depth stays where it was read, and each reading takes the colour of the pixel that shows it; a
    point that the colour camera cannot see, for something nearer to it, is black.
    """

    colour: Lens
    depth: Lens
    colour_from_depth: Array | None = None

    def __post_init__(self) -> None:
        if self.colour_from_depth is not None:
            object.__setattr__(self, "colour_from_depth", read_only(self.colour_from_depth))

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the pictures made."""
        return self.depth.intrinsics

    def registered(
        self, colour: NDArray[np.uint8], depth: NDArray[np.float32]
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """The pair without distortion, colour (H, W, 3) at the depth's (H, W) pixels; depth in metres."""
        if not self.colour.straight:
            colour = _remapped(colour, self._colour_map, cv2.INTER_LINEAR)
        if not self.depth.straight:
            depth = _remapped(depth, self._depth_map, cv2.INTER_NEAREST)
        if self.colour_from_depth is None:
            return colour, depth
        return self._looked_up(colour, depth), depth

    @cached_property
    def _colour_map(self) -> Map:
        return self.colour.undistortion()

    @cached_property
    def _depth_map(self) -> Map:
        return self.depth.undistortion()

    @cached_property
    def _rays(self) -> NDArray[np.float32]:
        """(H, W, 3) of the depth camera, turned into the colour camera's axes."""
        assert self.colour_from_depth is not None
        return rotate(self.colour_from_depth[3:], self.depth.intrinsics.rays()).astype(np.float32)

    def _looked_up(self, colour: NDArray[np.uint8], depth: NDArray[np.float32]) -> NDArray[np.uint8]:
        assert self.colour_from_depth is not None
        i = self.colour.intrinsics
        read = depth > 0
        # where nothing was read, the colour is about right at the depth that most of the picture has
        guess = np.where(read, depth, np.float32(np.median(depth[read]) if read.any() else 1))
        points = self._rays * guess[..., None] + self.colour_from_depth[:3].astype(np.float32)
        z = np.maximum(points[..., 2], np.float32(1e-3))
        u = ((points[..., 0] / z) * i.fx + i.cx).astype(np.float32)
        v = ((points[..., 1] / z) * i.fy + i.cy).astype(np.float32)
        found = _remapped(colour, (u, v), cv2.INTER_LINEAR)
        found[read & self._hidden(u, v, z, read)] = 0
        return found

    def _hidden(
        self, u: NDArray[np.float32], v: NDArray[np.float32], z: NDArray[np.float32], read: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Where a point is behind another for the colour camera, on cells as wide as a pixel of depth."""
        i, d = self.colour.intrinsics, self.depth.intrinsics
        cell = max(1.0, 1.5 * i.fx / d.fx)
        columns, rows = int(i.width / cell) + 1, int(i.height / cell) + 1
        inside = read & (u >= 0) & (v >= 0) & (u < i.width) & (v < i.height)
        cells = (v[inside] / cell).astype(np.intp) * columns + (u[inside] / cell).astype(np.intp)
        nearest = np.full(rows * columns, np.inf, np.float32)
        np.minimum.at(nearest, cells, z[inside])
        hidden = np.zeros(read.shape, bool)
        hidden[inside] = z[inside] > nearest[cells] * (1 + _HIDDEN) + _HIDDEN / 2
        return hidden


def _remapped(picture: NDArray[Any], to: Map, how: int) -> NDArray[Any]:
    return np.asarray(cv2.remap(picture, *to, how, borderMode=cv2.BORDER_CONSTANT, borderValue=0))
