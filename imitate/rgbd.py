"""What an RGB-D camera gives: intrinsics and frames, whatever the file or simulator behind them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, read_only


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
