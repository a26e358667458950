"""What an RGB-D camera gives: intrinsics and frames, whatever the file or simulator behind them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import IDENTITY, Array, read_only

NEAREST = 0.01
"""m in front of a camera from which a point can be seen."""


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera; x right, y down, z forward. Lengths in pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def rays(self) -> Array:
        """(H, W, 3) the point at depth 1 m behind each pixel's centre; times the depth, the pixel's point."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        x, y = (u - self.cx) / self.fx, (v - self.cy) / self.fy
        return np.stack([x, y, np.ones_like(x)], axis=-1)

    def project(self, points: Array) -> Array:
        """(N, 2) pixels, column and row, that show points (N, 3); NaN where one is not in front of it."""
        with np.errstate(invalid="ignore"):
            z = np.where(points[:, 2] > NEAREST, points[:, 2], np.nan)
        return np.stack([self.fx * points[:, 0] / z + self.cx, self.fy * points[:, 1] / z + self.cy], axis=1)


@dataclass(frozen=True)
class RgbdFrame:
    """One registered picture.

    Attributes:
        t: seconds.
        colour: (H, W, 3) uint8, red green blue.
        depth: (H, W) float32 metres along the optical axis; 0 where there is no reading.
    """

    t: float
    colour: NDArray[np.uint8]
    depth: NDArray[np.float32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "colour", read_only(self.colour, np.uint8))
        object.__setattr__(self, "depth", read_only(self.depth, np.float32))


class RgbdSource(Protocol):
    """Registered pictures of one camera, from a file, a folder or a simulator.

    Attributes:
        intrinsics: of every frame; colour and depth are registered to it.
        count: how many frames there are, as far as is known before they are read.
    """

    @property
    def intrinsics(self) -> Intrinsics: ...

    @property
    def count(self) -> int: ...

    def frames(self) -> Iterator[RgbdFrame]:
        """Every frame in order, read as it is asked for; t in seconds from the first."""


@dataclass(frozen=True)
class PointCloud:
    """What a depth camera saw at one moment.

    Attributes:
        points: (N, 3) metres in the camera's frame (x right, y down, z forward); NaN where nothing was read.
        colour: (N, 3) uint8, red green blue; None where the file has none.
        shape: (H, W) where the points are a picture's pixels, row by row; None where they are in no order.
        cloud_from_camera: (7,) the camera's pose in the frame in which a file gave the points.
        notes: what the operator ought to know, in words.
    """

    points: Array
    colour: NDArray[np.uint8] | None = None
    shape: tuple[int, int] | None = None
    cloud_from_camera: Array = field(default_factory=lambda: IDENTITY)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("points", "cloud_from_camera"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        if self.colour is not None:
            object.__setattr__(self, "colour", read_only(self.colour, np.uint8))
