"""A block's size and pose: first from its cluster as in the paper, then as what explains its pixels best."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from imitate.geometry import Array, from_yaw, read_only
from imitate.perception.particles import anneal
from imitate.perception.shapes import Float, Mask, Pixels, agreement, box_depth

PARTICLES = 400
LAYERS = 8
_FIRST_GUESS = np.array([0.004, 0.004, 0.1, 0.004, 0.004, 0.004])
"""standard deviations of the cluster's estimate: x, y (m), yaw (rad), sizes (m)."""


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


def fit_block(first: Block, pixels: Pixels, own: Mask, noise: float, generator: np.random.Generator) -> Block:
    """The block near ``first``, standing on the table, that agrees best with what was seen.

    Args:
        first: from `block_of_cluster`.
        pixels: of a view without motion, around the block.
        own: (M,) which of them show the block.
        noise: standard deviation of their depth, metres.
        generator: of the search.
    """

    def block(changes: Array) -> tuple[Array, Array]:
        sizes = np.maximum(first.size + changes[:, 3:], 0.004)
        positions = np.concatenate([first.pose[:2] + changes[:, :2], sizes[:, 2:] / 2], axis=1)
        yaws = 2 * np.arctan2(first.pose[5], first.pose[6]) + changes[:, 2]
        return from_yaw(positions, yaws), sizes

    def score(changes: Array) -> Float:
        poses, sizes = block(changes)
        return agreement(pixels, own, box_depth(pixels, poses, sizes), noise)

    guesses = _FIRST_GUESS * generator.standard_normal((PARTICLES, 6))
    best = anneal(guesses, score, LAYERS, generator)
    poses, sizes = block(best.mean[None])
    return Block(sizes[0], poses[0])
