"""Things that touch each other and differ in hue: told apart, and how high each of them stands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imitate.geometry import Array
from imitate.perception.shapes import Float, Mask

BIN, APART = 10, 2
"""degrees of one bin of hue, and empty bins between two colours."""
EMPTY, SHARE = 0.02, 0.1
"""share of a thing's points below which a bin is empty, and from which a colour is a part's."""
PARTED = 0.9
"""share of two colours' points on either side of a plane, else one is a pattern or a label on the other."""
STANDING = 0.02
"""m above the table from which the lowest point of a part is held up by another part."""


@dataclass(frozen=True)
class Part:
    """A part of one colour: indices of its points, the height it stands on, metres; whether one is on it."""

    points: NDArray[np.intp]
    floor: float
    covered: bool


def parts_by_hue(points: Array, hue: Float) -> list[Part]:
    """A thing's parts, one a colour, the lowest first; all of it where it has one colour or a pattern.

    Args:
        points: (N, 3) of one thing in the table's frame, metres.
        hue: (N,) degrees, NaN where grey.
    """
    whole = [Part(np.arange(len(points)), 0.0, False)]
    colours = _colours(hue)
    if not all(_apart(points[a], points[b]) for a, b in combinations(colours, 2)) or len(colours) < 2:
        return whole
    coloured = np.any(colours, axis=0)
    owner = np.argmax(colours, axis=0)
    _, nearest = cKDTree(points[coloured]).query(points[~coloured])
    owner[~coloured] = owner[coloured][nearest]
    parts = [np.flatnonzero(owner == k) for k in range(len(colours))]
    low, high = ([np.percentile(points[part, 2], share) for part in parts] for share in (2, 98))
    found: list[Part] = []
    order = np.argsort(low, kind="stable")
    for place, k in enumerate(order.tolist()):
        below = [high[j] for j in order[:place]]
        if not below or low[k] <= STANDING:
            found.append(Part(parts[k], 0.0, False))
            continue
        under = int(np.argmin(np.abs(np.array(below) - low[k])))
        found[under] = replace(found[under], covered=True)
        found.append(Part(parts[k], float(low[k] + below[under]) / 2, False))
    return found


def _colours(hue: Float) -> list[Mask]:
    """(N,) masks of the colours: runs of hues around the circle with a gap between them."""
    count = 360 // BIN
    known = (hue >= 0) & (hue < 360)
    bins = np.where(known, np.nan_to_num(hue) // BIN, 0).astype(int)
    full = np.bincount(bins[known], minlength=count) > EMPTY * len(hue)
    gaps = ~np.any([np.roll(full, step) for step in range(APART)], axis=0)
    if not gaps.any():
        return []
    start = int(np.argmax(gaps))
    turned = np.roll(full & np.roll(gaps, 1), -start)  # where, after a gap, a colour starts
    names = np.roll(np.cumsum(turned), start)
    masks = [known & full[bins] & (names[bins] == k) for k in range(1, int(turned.sum()) + 1)]
    return [mask for mask in masks if mask.sum() >= SHARE * len(hue)]


def _apart(one: Array, other: Array) -> bool:
    """Whether a plane parts the points (N, 3) of two colours; none does where one is a label on the other."""
    points = np.concatenate([one, other])
    sides = np.repeat([1.0, -1.0], [len(one), len(other)])
    weights = np.sqrt(np.repeat([1 / len(one), 1 / len(other)], [len(one), len(other)]))
    scaled = np.column_stack([(points - points.mean(axis=0)) / points.std(axis=0), np.ones(len(points))])
    plane = np.linalg.lstsq(scaled * weights[:, None], sides * weights, rcond=None)[0]
    right = scaled @ plane * sides > 0
    return bool(min(right[: len(one)].mean(), right[len(one) :].mean()) > PARTED)
