"""Which points of a view belong to which thing on the table."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imitate.geometry import Array
from imitate.perception.clusters import dense_parts
from imitate.perception.shapes import Mask, Pixels
from imitate.perception.tabletop import GATE, ROOM, Table, stands_on

VOXEL = 0.004
"""m, the finest grid on which points are clustered."""
APART = 0.01
"""m between the nearest points of two things, at least; more where a sensor's noise or spacing is more."""
SURE = 2 * GATE
"""standard deviations of its height from which a point alone stands for a thing."""
ABOVE = 0.005
"""m above the table, likewise, where the noise is less."""
HOVER = 0.02
"""m between the table and the lowest seen point of something that may hover."""
LONELY = 0.35
"""share of the usual number of neighbours, below which a point may be a flying pixel."""
AREA = 0.0004
"""m² of visible surface of the smallest thing."""


def spacing(points: Array) -> float:
    """The median distance in metres from a point to its nearest neighbour, from up to 500 of them."""
    if len(points) < 2:
        return 0.0
    some = points[:: max(1, len(points) // 500)]
    away, _ = cKDTree(points).query(some, k=2)
    return float(np.median(np.asarray(away)[:, 1]))


def dense(points: Array) -> Array:
    """Those points (N, 3) of a thing that have neighbours as its others have: flying pixels have few."""
    if len(points) < 2:
        return points
    counts = cKDTree(points).query_ball_point(points, 3 * spacing(points), return_length=True)
    return np.asarray(points[counts > LONELY * np.median(counts)])


def find_things(points: Array, table: Table) -> list[NDArray[np.intp]]:
    """Indices of the points of each thing on the table, the largest first, down to where it meets the table.

    What surely rises above the table is clustered; points less high go to the thing that they touch.

    Args:
        points: (N, 3) read, in the camera's frame, metres.
        table: found in them.
    """
    placed, noise = table.placed(points), table.height_noise(points)
    height = placed[:, 2]
    sure = np.flatnonzero((height > np.maximum(SURE * noise, ABOVE)) & (height < ROOM))
    if not len(sure):
        return []
    between = spacing(placed[sure])
    voxel = max(VOXEL, 1.5 * between)
    apart = max(APART, 2.5 * voxel, 4 * float(np.median(table.noise(points[sure, 2]))))
    cells, inside = np.unique(np.floor(placed[sure] / voxel), axis=0, return_inverse=True)
    fewest = max(5, int(AREA / voxel**2))
    parts = [part for part in dense_parts((cells + 0.5) * voxel, apart, 5) if len(part) >= fewest]
    owner = np.full(len(cells), -1)
    for k, part in enumerate(parts):
        owner[part] = k
    owned = owner[inside]
    kept = [k for k in range(len(parts)) if stands_on(table, placed[sure[owned == k]])]
    low = np.flatnonzero((height > GATE * noise) & (height < ROOM))
    labels = _nearest(placed, sure[owned >= 0], owned[owned >= 0], low, apart)
    return [low[labels == k] for k in kept]


def on_table(points: Array, table: Table) -> Mask:
    """(N,) which points are the table's own."""
    placed = table.placed(points)
    return table.reaches(placed) & (np.abs(placed[:, 2]) < SURE * table.height_noise(points))


def hovers(pixels: Pixels, own: NDArray[np.intp], table: Table) -> bool:
    """Whether the table is seen under most of a thing: a hand, or what it holds.

    Args:
        pixels: of the whole view.
        own: (K,) which show the thing.
        table: beneath it.
    """
    placed = pixels.points()
    thing = placed[own]
    if thing[:, 2].min() < HOVER:
        return False
    cell = 3 * spacing(thing)
    depth = pixels.depth.astype(float)
    floor = np.abs(placed[:, 2]) < GATE * table.noise(depth)
    low, high = thing[:, :2].min(axis=0), thing[:, :2].max(axis=0)
    under = placed[floor & np.all((placed[:, :2] > low) & (placed[:, :2] < high), axis=1), :2]
    covered = {tuple(c) for c in np.floor(thing[:, :2] / cell).astype(int)}
    bare = {tuple(c) for c in np.floor(under / cell).astype(int)}
    return len(covered & bare) > len(covered) / 2


def _nearest(
    placed: Array, known: NDArray[np.intp], owners: NDArray[np.intp], asked: NDArray[np.intp], reach: float
) -> NDArray[np.intp]:
    """The owner of the nearest known point of each point asked for, −1 where none is within reach."""
    if not len(known):
        return np.full(len(asked), -1)
    away, which = cKDTree(placed[known]).query(placed[asked], distance_upper_bound=reach)
    return np.where(np.isfinite(away), owners[np.minimum(which, len(known) - 1)], -1)
