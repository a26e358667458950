"""What a first view shows: the table, what stands on it, and which point belongs to which."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, inverse, read_only, rotate
from imitate.perception.block import Block, block_of_cluster, fit_block
from imitate.perception.colour import HUES, dominant_hue, hues, is_hue
from imitate.perception.shapes import Float, Mask, Pixels, box_depth
from imitate.perception.tabletop import PLANE, clusters, find_table
from imitate.settings import Perception

ROOM = 0.5
"""m above the table in which objects are looked for."""
OUTSIDE = 0.1
"""share of an object's points off the fitted block's visible faces, from which the block is uncertain."""


@dataclass(frozen=True)
class Table:
    """The plane that things stand on.

    Attributes:
        plane: (4,) a b c d with a·x + b·y + c·z + d = 0 in the camera's frame; (a b c) a unit normal
            towards the camera.
        inliers: points on it.
        table_from_camera: (7,) the table's frame: z up, z = 0 on it, x away from the camera.
        low, high: (2,) its extent in its own x and y, metres.
    """

    plane: Array
    inliers: int
    table_from_camera: Array
    low: Array
    high: Array

    def __post_init__(self) -> None:
        for name in ("plane", "table_from_camera", "low", "high"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


@dataclass(frozen=True)
class SeenObject:
    """One thing on the table.

    Attributes:
        name: its hue, "grey" where it has none or several, "object1" … where the view has no colour;
            numbered when repeated.
        block: its size and its pose in the table's frame.
        size_std: (3,) standard deviation of the block's size, metres.
        uncertain: whether one block does not account for what was seen; ``reason`` says why, in words.
        points: how many points it has.
    """

    name: str
    block: Block
    size_std: Array
    uncertain: bool
    reason: str
    points: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "size_std", read_only(self.size_std))

    @property
    def has_hue(self) -> bool:
        """Whether its name starts with a hue, by which it can be told from the rest."""
        return self.name.rstrip("0123456789") in HUES


@dataclass(frozen=True)
class FirstView:
    """Table, objects, and ``labels``: per point given −1 (none), 0 (table) or 1 … (objects, in order)."""

    table: Table
    objects: tuple[SeenObject, ...]
    labels: NDArray[np.int32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "labels", read_only(self.labels, np.int32))


def first_view(
    points: Array,
    colour: NDArray[np.uint8] | None,
    settings: Perception,
    seed: int,
    shape: tuple[int, int] | None = None,  # noqa: ARG001
) -> FirstView:
    """Find the table and the objects in one view without motion (the paper, Appendix A).

    Args:
        points: (N, 3) metres in the camera's frame (x right, y down, z forward); NaN where nothing was read.
        colour: (N, 3) uint8 red green blue, or None.
        settings: what the hand looks like, and the sensor's noise.
        seed: of every random draw.
        shape: (H, W) where the points are a picture's pixels, row by row.

    Raises:
        ImitateError: no table in it.
    """
    generator = np.random.default_rng(seed)
    points = np.asarray(points, float)
    read = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
    hue = _hues(colour, len(points))
    hand = is_hue(hue, settings.left_finger) | is_hue(hue, settings.right_finger)
    table = _table(points[read], seed)
    placed = np.full_like(points, np.nan)
    placed[read] = table.table_from_camera[:3] + rotate(table.table_from_camera[3:], points[read])
    over = _over(placed, table)
    labels = np.full(len(points), -1, np.int32)
    labels[over & (np.abs(placed[:, 2]) < PLANE)] = 0
    found = []
    for own in clusters(placed, over & ~hand):
        name = "object" if colour is None else dominant_hue(hue[own])
        found.append((name, own))
    found.sort(key=lambda pair: pair[0])
    objects = []
    for k, (name, own) in enumerate(found):
        labels[own] = k + 1
        pixels = _pixels(placed[read], points[read], hue[read], table)
        objects.append(_measured(name, pixels, labels[read] == k + 1, settings, generator))
    return FirstView(table, tuple(_numbered(objects)), labels)


def _hues(colour: NDArray[np.uint8] | None, count: int) -> Float:
    if colour is None:
        return np.full(count, np.nan, np.float32)
    return np.asarray(hues(colour[None])[0])


def _table(points: Array, seed: int) -> Table:
    table_from_camera = find_table(points, seed)
    camera_from_table = inverse(table_from_camera)
    normal = rotate(camera_from_table[3:], [0, 0, 1.0])
    placed = table_from_camera[:3] + rotate(table_from_camera[3:], points)
    on = np.abs(placed[:, 2]) < PLANE
    low, high = np.percentile(placed[on, :2], [0.5, 99.5], axis=0)
    plane = np.append(normal, -normal @ camera_from_table[:3])
    return Table(plane, int(on.sum()), table_from_camera, low, high)


def _over(placed: Array, table: Table) -> Mask:
    inside = np.all((placed[:, :2] > table.low) & (placed[:, :2] < table.high), axis=1)
    return np.asarray(inside & (placed[:, 2] < ROOM))


def _pixels(placed: Array, points: Array, hue: Float, table: Table) -> Pixels:
    """The points read as what a camera at the table's ``table_from_camera`` sees along its rays."""
    depth = points[:, 2].astype(np.float32)
    origin = table.table_from_camera[:3]
    return Pixels(origin, ((placed - origin) / points[:, 2:]).astype(np.float32), depth, hue)


def _measured(
    name: str, pixels: Pixels, own: Mask, settings: Perception, generator: np.random.Generator
) -> SeenObject:
    placed = pixels.points()
    rough = block_of_cluster(placed[own])
    reach = float(np.linalg.norm(rough.size))
    near = np.flatnonzero(np.linalg.norm(placed - rough.pose[:3], axis=1) < reach)
    near = near[:: max(1, len(near) // (4 * settings.pixels))]
    block, deviation = fit_block(rough, pixels.where(near), own[near], settings.depth_noise / 2, generator)
    seen = pixels.where(np.flatnonzero(own))
    away = np.abs(box_depth(seen, block.pose[None], block.size)[0] - seen.depth)
    outside = float(np.mean(~(away < 3 * settings.depth_noise)))
    reason = f"{outside:.0%} of its points lie off one block's faces" if outside > OUTSIDE else ""
    return SeenObject(name, block, deviation, bool(reason), reason, int(own.sum()))


def _numbered(objects: list[SeenObject]) -> list[SeenObject]:
    counts: Counter[str] = Counter()
    named = []
    for thing in objects:
        counts[thing.name] += 1
        first = counts[thing.name] == 1 and thing.name != "object"
        named.append(thing if first else replace(thing, name=f"{thing.name}{counts[thing.name]}"))
    return named
