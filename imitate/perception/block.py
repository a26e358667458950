"""A block's size and pose: first from its cluster as in the paper, then as what explains its pixels best."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from imitate.geometry import Array, from_yaw, read_only
from imitate.perception.particles import anneal
from imitate.perception.shapes import Float, Mask, Pixels, agreement, box_depth

PARTICLES, LAYERS = 400, 10
AFAR, FEW = 3, 700
"""searches far from the cluster's estimate, and pixels that they are content with."""
_CLOSE = np.array([0.004, 0.004, 0.1, 0.004, 0.004, 0.004])
"""standard deviations of the cluster's estimate: x, y (m), yaw (rad), sizes (m)."""
_FAR, _TURNED = np.array([0.15, 0.15, 0.0, 0.25, 0.25, 0.1]), np.array([0.0, 0.0, 0.4, 0.0, 0.0, 0.0])
"""of a cluster that flying pixels made too long: the same as shares of its size; and how it may be turned."""


@dataclass(frozen=True)
class Block:
    """A box: its (3,) size along its x, y, z and the (7,) pose of its centre in the table's frame."""

    size: Array
    pose: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", read_only(self.size))
        object.__setattr__(self, "pose", read_only(self.pose))


def block_of_cluster(points: Array) -> Block:
    """The block whose visible points (N, 3) these are, standing on the table (the paper, Appendix A).

    Width and length from the rectangle of least area around the points seen from above, height from the
    three highest points; x along the width, y along the length.
    """
    (x, y), sides, degrees = cv2.minAreaRect(points[:, :2].astype(np.float32))
    yaw = np.deg2rad(degrees)
    if sides[0] > sides[1]:
        sides, yaw = sides[::-1], yaw + np.pi / 2
    yaw = (yaw + np.pi / 2) % np.pi - np.pi / 2
    height = float(np.sort(points[:, 2])[-3:].mean())
    return Block(np.array([*sides, height]), from_yaw([x, y, height / 2], yaw))


def upright(block: Block, floor: float, top: float) -> Block:
    """The same block from ``floor`` to ``top``, metres above the table."""
    height = max(top - floor, 0.004)
    size, pose = np.array(block.size), np.array(block.pose)
    size[2], pose[2] = height, floor + height / 2
    return Block(size, pose)


def fit_block(
    first: Block,
    pixels: Pixels,
    own: Mask,
    noise: float,
    generator: np.random.Generator,
    covered: bool = False,
) -> Block:
    """The block near ``first``, standing as high as that, that agrees best with what was seen.

    Close to ``first``; and, as a few flying pixels make that too long, close to the best far from it.

    Args:
        first: from `block_of_cluster`.
        pixels: of a view without motion, around the block, in no order.
        own: (M,) which of them show the block.
        noise: standard deviation of their depth, metres.
        generator: of the search.
        covered: by another block, so that most of its faces cannot be seen and ``first`` must be trusted.
    """
    if covered:
        return _search(first, pixels, own, noise, _CLOSE, generator)[0]
    few = pixels.where(np.arange(min(FEW, len(own)))), own[:FEW]
    far = np.maximum(_CLOSE, _FAR * first.size[[1, 1, 1, 0, 1, 2]] + _TURNED)
    found = [_search(first, *few, noise, far, generator) for _ in range(AFAR)]
    starts = first, max(found, key=lambda pair: pair[1])[0]
    fits = [_search(start, pixels, own, noise, _CLOSE, generator) for start in starts]
    return max(fits, key=lambda pair: pair[1])[0]


def _search(
    first: Block, pixels: Pixels, own: Mask, noise: float, spread: Array, generator: np.random.Generator
) -> tuple[Block, float]:
    """The best block around ``first``, and its log-likelihood."""
    floor = first.pose[2] - first.size[2] / 2

    def block(changes: Array) -> tuple[Array, Array]:
        sizes = np.maximum(first.size + changes[:, 3:], 0.004)
        positions = np.concatenate([first.pose[:2] + changes[:, :2], floor + sizes[:, 2:] / 2], axis=1)
        yaws = 2 * np.arctan2(first.pose[5], first.pose[6]) + changes[:, 2]
        return from_yaw(positions, yaws), sizes

    def score(changes: Array) -> Float:
        poses, sizes = block(changes)
        return agreement(pixels, own, box_depth(pixels, poses, sizes), noise)

    best = anneal(spread * generator.standard_normal((PARTICLES, 6)), score, LAYERS, generator)
    poses, sizes = block(best.mean[None])
    return Block(sizes[0], poses[0]), best.score
