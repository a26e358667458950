"""What a camera should see of boxes and cylinders, and how well that agrees with what it saw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from imitate.geometry import Array

Float = NDArray[np.float32]
Mask = NDArray[np.bool_]

LIMIT = 4.5
"""log-likelihood that a pixel can cost at most: a residual of three standard deviations."""


@dataclass(frozen=True)
class Pixels:
    """Some pixels of one frame, in the table's frame.

    Attributes:
        origin: (3,) the camera's place.
        rays: (M, 3) directions; times the depth, from the origin to the point seen.
        depth: (M,) metres, 0 where there is no reading.
        hue: (M,) degrees, NaN where grey.
    """

    origin: Array
    rays: Float
    depth: Float
    hue: Float

    def points(self) -> Array:
        """(M, 3) the points seen, metres; the camera's place where there is no reading."""
        return np.asarray(self.origin + self.rays * self.depth[:, None], float)

    def where(self, kept: Mask | NDArray[np.intp]) -> Pixels:
        """Only those pixels, by mask or by index."""
        return Pixels(self.origin, self.rays[kept], self.depth[kept], self.hue[kept])


def box_depth(pixels: Pixels, poses: Array, sizes: Array) -> Float:
    """(N, M) depth at which each pixel's ray enters each box; infinite where it misses.

    Args:
        pixels: M of them.
        poses: (N, 7) of the boxes' centres.
        sizes: (N, 3) or (3,) along the boxes' axes, metres.
    """
    start, step = _in_frames(pixels, poses)
    half = np.broadcast_to(np.asarray(sizes, np.float32) / 2, (len(poses), 3))
    near, far = _slab(start[:, 0], step[0], half[:, 0])
    for k in (1, 2):
        low, high = _slab(start[:, k], step[k], half[:, k])
        np.maximum(near, low, out=near)
        np.minimum(far, high, out=far)
    near[(near >= far) | (near <= 0)] = np.inf
    return near


def cylinder_depth(pixels: Pixels, poses: Array, radius: float, length: float) -> Float:
    """(N, M) depth at which each ray enters each capped cylinder about its z; infinite where it misses."""
    start, step = _in_frames(pixels, poses)
    near, far = _slab(start[:, 2], step[2], np.full(len(poses), length / 2, np.float32))
    x, y = start[:, :1], start[:, 1:2]
    a = step[0] ** 2 + step[1] ** 2
    b = x * step[0] + y * step[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * (x * x + y * y - np.float32(radius**2)))
        near, far = np.maximum(near, (-b - root) / a), np.minimum(far, (-b + root) / a)
        near[~((near < far) & (near > 0))] = np.inf
    return np.asarray(near)


def agreement(pixels: Pixels, own: Mask, predicted: Float, noise: float) -> Float:
    """(N,) log-likelihood of what was seen, given where each of N guesses would be seen.

    A pixel of the body's own colour must be hit, at its depth where that was read. Any other must not be hit,
    unless something nearer stands before the body.

    Args:
        pixels: M of them.
        own: (M,) whether the pixel has the body's colour.
        predicted: (N, M) depth, infinite where missed.
        noise: standard deviation of depth, metres.
    """
    scale = np.float32(1 / noise)
    seen, other = predicted[:, own], predicted[:, ~own]
    residual = (seen - pixels.depth[own]) * scale
    residual[(pixels.depth[own] == 0) & np.isfinite(seen)] = 0
    cost = np.minimum(residual * residual / 2, LIMIT).sum(axis=1)
    depth = np.where(pixels.depth[~own] > 0, pixels.depth[~own], -np.inf).astype(np.float32)
    through = np.isfinite(other) & (depth > other - np.float32(3 * noise))
    return np.asarray(-cost - LIMIT * through.sum(axis=1), np.float32)


def _in_frames(pixels: Pixels, poses: Array) -> tuple[Float, Float]:
    """The rays in N bodies' frames: starts (N, 3) and steps (3, N, M)."""
    turned = Rotation.from_quat(poses[:, 3:]).as_matrix()  # table_from_body
    start = np.einsum("nij,ni->nj", turned, pixels.origin - poses[:, :3]).astype(np.float32)
    axes = turned.transpose(2, 1, 0).astype(np.float32)[..., None]
    x, y, z = np.ascontiguousarray(pixels.rays.T)
    # Not a matrix product: BLAS would wake its threads for it, and they cost more than they do.
    step = axes[:, 0] * x
    step += axes[:, 1] * y
    step += axes[:, 2] * z
    return start, step


def _slab(start: Float, step: Float, half: NDArray[Any]) -> tuple[Float, Float]:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, b = (-half - start)[:, None] / step, (half - start)[:, None] / step
    return np.minimum(a, b), np.maximum(a, b)
