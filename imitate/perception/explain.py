"""Parts of a view, each explained by a block; those that one block explains as well are one thing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imitate.perception.block import Block, block_of_cluster, fit_block, upright
from imitate.perception.colour import HUES, dominant_hue
from imitate.perception.doubt import EDGE, STRAIN, doubt, seen_through, size_deviation, strained
from imitate.perception.shapes import Mask, Pixels, agreement, box_depth
from imitate.perception.tabletop import GATE, Table, stands_on
from imitate.perception.things import dense, spacing

AROUND = 0.07
"""m around a thing, as far as what is seen there says where it ends."""
WORSE = 0.8
"""log-likelihood a point by which one block may explain two parts worse than a block each: it has half their
parameters. Neither part may be given up for the other."""
HOPELESS = 0.5
"""strain of a part by its own block, from which it says nothing of what it belongs to."""
BETWEEN = 0.3
"""pixels that see through the rectangle around two parts, as a share of theirs, above which they are two."""


@dataclass(frozen=True)
class Explained:
    """Some points of a view and the block that explains them best.

    Attributes:
        own: (K,) indices into the view's pixels.
        block: in the table's frame.
        pixels, mine: those that were compared with it, and which of them are its own.
        noise, tolerance: standard deviation of their depth, and what noise and their width explain, metres.
        loss: log-likelihood that a point of its own costs.
    """

    own: NDArray[np.intp]
    block: Block
    pixels: Pixels
    mine: Mask
    noise: float
    tolerance: float
    loss: float

    def doubt(self) -> str:
        """Why one block does not account for them, in words; empty where it does."""
        return doubt(self.block, self.pixels, self.mine, self.tolerance)

    def size_deviation(self, table: Table) -> NDArray[np.float64]:
        """(3,) standard deviation of the block's size, metres."""
        edge = EDGE * table.scatter * float(np.median(self.pixels.depth[self.mine]))
        return size_deviation(self.block, self.pixels, self.mine, self.noise, edge)


def explain(
    pixels: Pixels,
    own: NDArray[np.intp],
    others: Mask,
    table: Table,
    most: int,
    generator: np.random.Generator,
    of: NDArray[np.intp] | None = None,
    floor: float = 0.0,
    covered: bool = False,
) -> Explained:
    """The block that explains these pixels best.

    Args:
        pixels: of the whole view.
        own: (K,) which show the thing.
        others: (M,) which of all show things, this one or others.
        table: that it stands on.
        most: pixels that are compared.
        generator: of the search and of which pixels are compared.
        of: (L,) the pixels of several things that touch, where it is one of them.
        floor: metres above the table that it stands on.
        covered: whether something stands on it.
    """
    heights = np.sort(pixels.where(own).points()[:, 2])
    rough = _rough(pixels, own if of is None else of)
    rough = upright(rough, floor, float(heights[-3:].mean()))
    chosen, mine, noise, tolerance = _compared(pixels, own, others, rough, table, most, generator)
    block = fit_block(rough, chosen, mine, noise, generator, covered)
    score = agreement(chosen, mine, box_depth(chosen, block.pose[None], block.size), noise)
    return Explained(own, block, chosen, mine, noise, tolerance, -float(score[0]) / max(int(mine.sum()), 1))


def joined(
    parts: list[Explained],
    pixels: Pixels,
    others: Mask,
    table: Table,
    most: int,
    generator: np.random.Generator,
) -> list[Explained]:
    """The parts, with those made one that one block explains as well as a block each; no two hues are one.

    What stands before a thing can hide its middle. Arguments as of `explain`.
    """
    done: list[Explained] = []
    for part in parts:
        whole = part
        while True:
            fits = (
                (other, _together(whole, other, pixels, others, table, most, generator)) for other in done
            )
            found = next(((other, both) for other, both in fits if both is not None), None)
            if found is None:
                break
            done = [other for other in done if other is not found[0]]
            whole = found[1]
        done.append(whole)
    return done


def _together(
    a: Explained,
    b: Explained,
    pixels: Pixels,
    others: Mask,
    table: Table,
    most: int,
    generator: np.random.Generator,
) -> Explained | None:
    own = np.concatenate([a.own, b.own])
    colours = {dominant_hue(pixels.hue[part.own]) for part in (a, b)}
    if len(colours & set(HUES)) > 1 or not stands_on(table, pixels.where(own).points()):
        return None
    rough = _rough(pixels, own)
    few, mine, _, tolerance = _compared(pixels, own, others, rough, table, most // 4, generator)
    if seen_through(rough, few, mine, tolerance) > BETWEEN:
        return None
    both = explain(pixels, own, others, table, most, generator)
    each = (a.loss * len(a.own) + b.loss * len(b.own)) / len(own)
    if both.loss > each + WORSE or any(_given_up(part, both, pixels) for part in (a, b)):
        return None
    return both


def _given_up(part: Explained, both: Explained, pixels: Pixels) -> bool:
    """Whether the block of both parts leaves this one aside, or no block explains it in the first place."""
    points = pixels.where(part.own).points()
    alone, now = (strained(of.block, points, of.tolerance) for of in (part, both))
    return now > alone + STRAIN or alone > HOPELESS


def _rough(pixels: Pixels, own: NDArray[np.intp]) -> Block:
    return block_of_cluster(dense(pixels.where(own).points()))


def _compared(
    pixels: Pixels,
    own: NDArray[np.intp],
    others: Mask,
    rough: Block,
    table: Table,
    most: int,
    generator: np.random.Generator,
) -> tuple[Pixels, Mask, float, float]:
    """(pixels, which are its own, noise, tolerance) that say where a thing is and where it ends."""
    placed = pixels.where(own).points()
    noise = float(table.noise(np.array(np.median(pixels.depth[own]))))
    tolerance = GATE * noise + spacing(placed)
    is_own = np.zeros(len(pixels.depth), bool)
    is_own[own] = True
    shown = np.isfinite(box_depth(pixels, rough.pose[None], rough.size + 2 * AROUND)[0])
    near = generator.permutation(np.flatnonzero(shown))[:most]
    # Where a thing meets the table a pixel could be either's: it is no evidence.
    away, _ = cKDTree(placed).query(pixels.where(near).points(), distance_upper_bound=tolerance)
    near = near[others[near] | ~np.isfinite(away)]
    return pixels.where(near), is_own[near], noise, tolerance
