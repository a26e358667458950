"""How well guesses of where a body is agree with the pixels around it, and what hides it.

A pixel of the body's own colour must be hit by the body, at the depth that was read there. Any other must
not be hit, unless something nearer was read there or another body is known to be there. A body without a
colour of its own has the readings above the table that nothing else accounts for; each may be a stranger's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from imitate.geometry import Array
from imitate.perception.colour import is_hue
from imitate.perception.shapes import LIMIT, Float, Mask, Pixels, Places, box_nearness, places

UNREAD = 1.5
"""log-likelihood lost where a body covers a pixel without a reading that has not its colour."""
STRANGE = 1.5
"""log-likelihood lost where a reading that could be a colourless body's is a stranger's."""
LOW = 2.0
"""standard deviations above the table below which a pixel of the body's colour counts neither way."""
TALL = 0.01
"""m above the table from which a reading may belong to a body without colour."""


class Body(Protocol):
    """Something whose surface is known in this frame and may stand before another body."""

    @property
    def hue(self) -> str | None: ...

    @property
    def is_lost(self) -> bool: ...

    def nearness(self, pixels: Pixels) -> Float:
        """(M,) one over the depth of its surface, 0 where there is none."""


@dataclass(frozen=True)
class Fit:
    """How one guess agrees with its pixels, counted in pixels.

    Attributes:
        shown: hit, and seen as predicted.
        against: hit, and seen otherwise, with nothing nearer that would excuse it.
        hidden: hit, and behind something nearer or known.
        missed: of the body's own colour, and not hit.
        score: log-likelihood a pixel of those that could show the body.
    """

    shown: int
    against: int
    hidden: int
    missed: int
    score: float

    @property
    def visible(self) -> float:
        """Share of the body's outline that shows it."""
        return self.shown / max(self.shown + self.against + self.hidden, 1)

    @property
    def agreement(self) -> float:
        """Share of what should or does show the body that is as predicted."""
        return self.shown / max(self.shown + self.against + self.missed, 1)


class Evidence:
    """What some pixels say about one body; ``pixels`` are they in the order that scores expect.

    Args:
        pixels: around the body.
        own: (M,) which could show it: by colour, or for a body without colour by standing above the table.
        known: (M,) which show another body, or are behind one: they count neither for nor against.
        noise: standard deviation of depth, metres.
        coloured: whether ``own`` is by colour.
    """

    def __init__(self, pixels: Pixels, own: Mask, known: Mask, noise: float, coloured: bool = True) -> None:
        read = pixels.depth > 0
        own, other = own & ~known, ~own & ~known
        groups = [own & read, own & ~read, other & read, other & ~read, known]
        order = np.concatenate([np.flatnonzero(group) for group in groups])
        self.order, self.edges = order, np.cumsum([int(group.sum()) for group in groups])
        self.pixels, self.coloured = pixels.where(order), coloured
        depth = self.pixels.depth
        self._scaled = depth[: self.edges[0]] / np.float32(noise)
        self._squared = self._scaled * depth[: self.edges[0]]
        excused = np.float32(3 * noise)
        self._nearer = 1 / np.maximum(depth + excused, 1e-6)
        self._farther = self._nearer if coloured else 1 / np.maximum(depth - excused, 1e-6)

    @property
    def count(self) -> int:
        """Of the pixels that could show the body."""
        return int(self.edges[1])

    def points(self) -> Array:
        """(A, 3) the readings that could show the body, in the table's frame."""
        return self.pixels.where(np.arange(self.edges[0])).points()

    def score(self, near: Float) -> Float:
        """(N,) log-likelihoods of guesses that are seen at nearness (N, M); 0 where missed."""
        a, b, c, d, _ = self.edges
        cost = self._residuals(near[:, :a])
        if not self.coloured:
            cost = np.where(near[:, :a] > self._nearer[:a], cost, np.float32(STRANGE))
        total = cost.sum(axis=1)
        total += LIMIT * np.count_nonzero(near[:, a:b] == 0, axis=1)
        total += LIMIT * np.count_nonzero(near[:, b:c] > self._farther[b:c], axis=1)
        total += UNREAD * np.count_nonzero(near[:, c:d], axis=1)
        return np.asarray(-total, np.float32)

    def fit(self, near: Float) -> Fit:
        """How one guess, seen at nearness (M,), agrees."""
        a, b, c, _, _ = self.edges
        hit = near > 0
        good = hit[:a] & (self._residuals(near[None, :a])[0] < LIMIT)
        wrong = hit[:a] & ~good
        strange = int((wrong & (near[:a] <= self._nearer[:a])).sum()) if not self.coloured else 0
        through = int((near[b:c] > self._farther[b:c]).sum())
        return Fit(
            shown=int(good.sum() + hit[a:b].sum()),
            against=int(wrong.sum()) - strange + through,
            hidden=strange + int(hit[b:].sum()) - through,
            missed=int((~hit[:b]).sum()) if self.coloured else 0,
            score=float(self.score(near[None])[0]) / max(self.count, 1),
        )

    def _residuals(self, near: Float) -> Float:
        """(N, A) log-likelihoods lost at the readings; z − 1/n is z − z²n to first order."""
        residual = self._scaled - self._squared * near
        np.multiply(residual, residual, out=residual)
        residual *= np.float32(0.5)
        return np.asarray(np.minimum(residual, LIMIT, out=residual))


class BoxEvidence:
    """What pixels say about a body that is a box of ``size`` (3,)."""

    def __init__(self, seen: Evidence, size: Array) -> None:
        self._seen, self._size = seen, size

    @property
    def count(self) -> int:
        """Of the pixels that could show the body."""
        return self._seen.count

    def points(self) -> Array:
        """(A, 3) the readings that could show the body, in the table's frame."""
        return self._seen.points()

    def score(self, guesses: Places) -> Float:
        """(N,) log-likelihoods of the body at N places."""
        pixels = self._seen.pixels
        return self._seen.score(box_nearness(pixels.origin, pixels.rays, guesses, self._size))

    def fit(self, pose: Array) -> Fit:
        """How one pose (7,) agrees."""
        pixels = self._seen.pixels
        return self._seen.fit(box_nearness(pixels.origin, pixels.rays, places(pose[None]), self._size)[0])


def evidence_for(hue: str | None, pixels: Pixels, others: Sequence[Body], noise: float) -> Evidence:
    """The evidence for a body of this hue (None: without colour) beside others whose place is known.

    Pixels of the body's own hue are another's only where that has the same hue.
    """
    height, read = pixels.origin[2] + pixels.rays[:, 2] * pixels.depth, pixels.depth > 0
    own = read & (height > TALL) if hue is None else is_hue(pixels.hue, hue)
    # The body's colour on the table is the table's grain, a reflection or the body's lowest edge.
    known = own & read & (height < LOW * noise)
    for other in others:
        if other.is_lost:
            continue
        near = other.nearness(pixels)
        away = np.abs(pixels.depth * near - 1) < 3 * noise * near
        taken = (near > 0) & (away | (pixels.depth == 0))
        known |= taken if hue in (None, other.hue) else taken & ~own
    return Evidence(pixels, own, known, noise, hue is not None)
