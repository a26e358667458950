"""What a first view shows: the table, what stands on it, and which point belongs to which."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, read_only
from imitate.perception.block import Block
from imitate.perception.colour import HUES, dominant_hue
from imitate.perception.explain import Explained, explain, joined
from imitate.perception.fingers import FingerColours, finger_colours, worn
from imitate.perception.hidden import cut_off, hidden_end
from imitate.perception.shapes import Float, Mask, Pixels
from imitate.perception.stacks import parts_by_hue
from imitate.perception.tabletop import Table, find_table
from imitate.perception.things import find_things, hovers, on_table
from imitate.settings import Perception


@dataclass(frozen=True)
class SeenObject:
    """One thing on the table.

    Attributes:
        name: its hue, "grey" where it has none, several or a finger's, "object1" … without colour;
            numbered when repeated.
        block: its size and its pose in the table's frame.
        size_std: (3,) standard deviation of the block's size, metres.
        uncertain: whether one block does not account for what was seen, or may be a part of what is hidden;
            ``reason`` says why, in words.
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

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the table or an object may be something else, a sentence each."""
        table = f"table: doubtful, it may be another plane: {self.table.doubt}"
        things = (
            f"{thing.name}: uncertain, it may be more than one thing or no block: {thing.reason}"
            for thing in self.objects
            if thing.uncertain
        )
        return (*([table] if self.table.doubt else []), *things)


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
    flat = on_table(points[seen], table)
    labels[seen[flat]] = 0
    noise = float(table.noise(np.array(np.median(points[seen, 2]))))
    pixels = _pixels(points[seen], hue[seen], table)
    free = np.flatnonzero(~worn(points[seen], sides[seen], settings, noise))
    found = [free[thing] for thing in find_things(points[seen[free]], table)]
    things = _explained(found, pixels, table, 4 * settings.pixels, generator)
    names = ["object" if colour is None else dominant_hue(pixels.hue[thing.own]) for thing in things]
    order = sorted(range(len(things)), key=lambda k: (names[k], -len(things[k].own)))
    for label, k in enumerate(order):
        labels[seen[things[k].own]] = label + 1
    sizes = [thing.size_deviation(table) for thing in things]
    reasons = _reasons(things, sizes, pixels, ~flat & (pixels.points()[:, 2] > 0))
    objects = [
        SeenObject(names[k], things[k].block, sizes[k], bool(reasons[k]), reasons[k], len(things[k].own))
        for k in order
    ]
    if not objects and not table.doubt:
        table = replace(table, doubt="nothing stands on it")
    return FirstView(table, tuple(_numbered(objects)), labels)


def _explained(
    found: list[NDArray[np.intp]], pixels: Pixels, table: Table, most: int, generator: np.random.Generator
) -> list[Explained]:
    """Things, each with its block: parts of one made one again, different hues that touch told apart."""
    others = np.zeros(len(pixels.depth), bool)
    for own in found:
        others[own] = True
    whole = [explain(pixels, own, others, table, most, generator) for own in found]
    things: list[Explained] = []
    for thing in joined(whole, pixels, others, table, most, generator):
        if hovers(pixels, thing.own, table):
            continue
        parts = parts_by_hue(pixels.where(thing.own).points(), pixels.hue[thing.own])
        if len(parts) == 1:
            things.append(thing)
            continue
        for part in parts:
            own = thing.own[part.points]
            things.append(
                explain(pixels, own, others, table, most, generator, thing.own, part.floor, part.covered)
            )
    return things


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


def _pixels(points: Array, hue: Float, table: Table) -> Pixels:
    """Points read as what a camera at the table's ``table_from_camera`` sees along its rays."""
    depth = points[:, 2].astype(np.float32)
    origin = table.table_from_camera[:3]
    rays = (table.placed(points) - origin) / points[:, 2:]
    return Pixels(origin, rays.astype(np.float32), depth, hue)


def _reasons(things: list[Explained], sizes: list[Array], pixels: Pixels, above: Mask) -> list[str]:
    """Why each thing is uncertain, in words; empty where it is not.

    Beside something that no block explains, a thing of which an end is hidden may be a part of that.

    Args:
        sizes: standard deviation (3,) of each.
        above: (M,) which pixels show something above the table.
    """
    reasons = [thing.doubt() for thing in things]
    if not any(reasons):
        return reasons
    strange = above.copy()
    for thing, reason in zip(things, reasons, strict=True):
        strange[thing.own] = bool(reason)
    return [
        reason or hidden_end(size) or cut_off(pixels, thing.own, strange, thing.tolerance)
        for thing, size, reason in zip(things, sizes, reasons, strict=True)
    ]


def _numbered(objects: list[SeenObject]) -> list[SeenObject]:
    counts: Counter[str] = Counter()
    named = []
    for thing in objects:
        counts[thing.name] += 1
        first = counts[thing.name] == 1 and thing.name != "object"
        named.append(thing if first else replace(thing, name=f"{thing.name}{counts[thing.name]}"))
    return named
