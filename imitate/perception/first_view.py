"""What a first view shows: the table, what stands on it, and which point belongs to which."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imitate.geometry import Array, read_only
from imitate.perception.block import Block, block_of_cluster, fit_block, upright
from imitate.perception.colour import HUES, dominant_hue
from imitate.perception.doubt import EDGE, doubt, size_deviation
from imitate.perception.fingers import FingerColours, finger_colours, worn
from imitate.perception.shapes import Float, Pixels, box_depth
from imitate.perception.stacks import Part, parts_by_hue
from imitate.perception.tabletop import GATE, Table, find_table
from imitate.perception.things import dense, find_things, on_table, spacing
from imitate.settings import Perception

AROUND = 0.07
"""m around a thing, as far as what is seen there says where it ends."""


@dataclass(frozen=True)
class SeenObject:
    """One thing on the table.

    Attributes:
        name: its hue, "grey" where it has none, several or a finger's, "object1" … without colour;
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
    """What was found.

    Attributes:
        table: what things stand on.
        objects: by name.
        labels: (N,) of the points given: −1 none, 0 table, 1 … objects in order.
    """

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
    shape: tuple[int, int] | None = None,
    fingers: FingerColours | None = None,
) -> FirstView:
    """Find the table and the objects in one view without motion (the paper, Appendix A).

    Args:
        points: (N, 3) metres in the camera's frame (x right, y down, z forward); NaN where nothing was read.
        colour: (N, 3) uint8 red green blue, or None.
        settings: what the hand looks like, and the sensor's noise.
        seed: of every random draw.
        shape: (H, W) where the points are a picture's pixels, row by row.
        fingers: their colours; None: as the settings say, looked up in this view.

    Raises:
        ImitateError: no table in it.
        UsageError: a finger's colour in the settings cannot be resolved.
    """
    generator = np.random.default_rng(seed)
    points = np.asarray(points, float)
    seen = np.flatnonzero(np.isfinite(points).all(axis=1) & (points[:, 2] > 0))
    table = find_table(points[seen], seed)
    if fingers is None and colour is not None:
        fingers = finger_colours(settings, colour.reshape(*shape, 3) if shape else None)
    hue, sides = _coloured(colour, fingers, len(points), shape)
    labels = np.full(len(points), -1, np.int32)
    labels[seen[on_table(points[seen], table)]] = 0
    noise = float(table.noise(np.array(np.median(points[seen, 2]))))
    free = seen[~worn(points[seen], sides[seen], settings, noise)]
    placed = table.placed(points[seen])
    pixels = _pixels(placed, points[seen], hue[seen], table)
    found = []
    for thing in find_things(points[free], table):
        whole = free[thing]
        for part in parts_by_hue(table.placed(points[whole]), hue[whole]):
            own = whole[part.points]
            found.append(("object" if colour is None else dominant_hue(hue[own]), own, whole, part))
    found.sort(key=lambda one: one[0])
    for k, (_, own, _, _) in enumerate(found):
        labels[own] = k + 1
    objects = []
    for k, (name, _, whole, part) in enumerate(found):
        rough = block_of_cluster(dense(table.placed(points[whole])))
        objects.append(_measured(name, pixels, labels[seen], k + 1, rough, part, table, settings, generator))
    return FirstView(table, tuple(_numbered(objects)), labels)


def _coloured(
    colour: NDArray[np.uint8] | None,
    fingers: FingerColours | None,
    count: int,
    shape: tuple[int, int] | None,
) -> tuple[Float, NDArray[np.int8]]:
    """Hues (N,), and which finger's colour each point has (N,)."""
    if colour is None or fingers is None:
        return np.full(count, np.nan, np.float32), np.zeros(count, np.int8)
    picture = colour.reshape(*(shape or (1, count)), 3)
    return fingers.hues(picture).reshape(-1), fingers.sides(picture).reshape(-1)


def _pixels(placed: Array, points: Array, hue: Float, table: Table) -> Pixels:
    """The points read as what a camera at the table's ``table_from_camera`` sees along its rays."""
    depth = points[:, 2].astype(np.float32)
    origin = table.table_from_camera[:3]
    return Pixels(origin, ((placed - origin) / points[:, 2:]).astype(np.float32), depth, hue)


def _measured(
    name: str,
    pixels: Pixels,
    labels: NDArray[np.int32],
    label: int,
    rough: Block,
    part: Part,
    table: Table,
    settings: Perception,
    generator: np.random.Generator,
) -> SeenObject:
    own = labels == label
    rough = upright(rough, part.floor, float(np.sort(pixels.points()[own, 2])[-3:].mean()))
    depth = np.median(pixels.depth[own]).astype(float)
    noise, edge = float(table.noise(depth)), EDGE * table.scatter * depth
    around = np.isfinite(box_depth(pixels, rough.pose[None], rough.size + 2 * AROUND)[0])
    near = generator.permutation(np.flatnonzero(around))[: 4 * settings.pixels]
    tree = cKDTree(pixels.points()[own])
    tolerance = GATE * noise + spacing(np.asarray(tree.data))
    # Where a thing meets the table a pixel could be either's: it is no evidence.
    away, _ = tree.query(pixels.where(near).points(), distance_upper_bound=tolerance)
    near = near[(labels[near] > 0) | ~np.isfinite(away)]
    clear, mine = pixels.where(near), own[near]
    block = fit_block(rough, clear, mine, noise, generator, part.covered)
    reason = doubt(block, clear, mine, tolerance)
    deviation = size_deviation(block, clear, mine, noise, edge)
    return SeenObject(name, block, deviation, bool(reason), reason, int(own.sum()))


def _numbered(objects: list[SeenObject]) -> list[SeenObject]:
    counts: Counter[str] = Counter()
    named = []
    for thing in objects:
        counts[thing.name] += 1
        first = counts[thing.name] == 1 and thing.name != "object"
        named.append(thing if first else replace(thing, name=f"{thing.name}{counts[thing.name]}"))
    return named
