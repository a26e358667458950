"""The most probable cuts of a sequence, exactly, under any score of a segment (Fearnhead & Liu 2007).

With geometric lengths the log posterior is a sum over segments, so the best segmentation is a shortest path
over all pairs of start and end: O(T²). Where a score knows how much one start can gain on another, those that
can win no more are left out, which changes nothing in the answer (as PELT does, Killick et al. 2012, but with
a bound for each two starts in the place of one constant for all).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array

Frames = NDArray[np.intp]
Scores = Callable[[Frames, Frames], Array]
"""starts (S,), ends (E,) → (E, S) log score of frames start…end−1 under the best model of a segment, with its
prior. Pairs with start ≥ end may hold anything."""
Lead = Callable[[Frames, Frames], Array]
"""starts (S,), others (O,) → (S, O) how much higher, at most, a segment from a start can score than one from
the other start to the same end, whatever the end; +inf where no bound is known."""

BLOCK = 64
"""ends that are scored together: numpy's calls, not its arithmetic, are what short blocks cost."""
PAIRS = 2**18
"""of start and end that are scored together at most, which bounds memory where no start is left out."""
MARGIN = 25.0
"""nats by which a start is beaten before sums leave it out: what it would add is less than 1e-10 of them."""
RIVALS = 64
"""starts against which all others are compared after each block."""


@dataclass(frozen=True)
class Block:
    """Some ends of the lattice, and the starts that count for them.

    Attributes:
        ends: (E,) frames, consecutive.
        starts: (S,) frames, increasing; the last E of them are ``ends`` themselves.
        scores: (E, S) log score of each pair, the prior of its length included; −inf where too short.
    """

    ends: Frames
    starts: Frames
    scores: Array


@dataclass(frozen=True)
class Lattice:
    """All pairs of start and end, and what a segment between them is worth.

    Attributes:
        scores: of segments.
        frames: T.
        expected_length: mean length of a segment, frames, > 1.
        shortest: frames that a segment has at least; a sequence shorter than that is one segment.
        lead: the bound by which starts are left out; None: all count.
    """

    scores: Scores
    frames: int
    expected_length: float
    shortest: int = 1
    lead: Lead | None = None

    @property
    def cost(self) -> float:
        """log p − log(1 − p), p = 1 / ``expected_length``: what each segment adds."""
        return -float(np.log(self.expected_length - 1))

    @property
    def constant(self) -> float:
        """T log(1 − p): what every segmentation has."""
        return self.frames * float(np.log1p(-1 / self.expected_length))

    def block(self, ends: Frames, starts: Frames) -> Block:
        """Scores of these pairs."""
        scores = self.scores(starts, ends) + self.cost
        least = min(self.shortest, self.frames)
        scores[ends[:, None] - starts < least] = -np.inf
        return Block(ends, starts, scores)

    def blocks(self, value: Array, margin: float = 0.0) -> Iterator[Block]:
        """Blocks from the first end to the last.

        Args:
            value: (T + 1,) of the frames before each start; the caller writes a block's ends before it asks
                for the next block.
            margin: nats by which a start is to be beaten before it is left out.
        """
        alive = np.zeros(1, np.intp)
        first = 1
        while first <= self.frames:
            size = max(1, min(BLOCK, PAIRS // len(alive)))
            ends = np.arange(first, min(first + size, self.frames + 1))
            starts = np.append(alive, ends)
            yield self.block(ends, starts)
            first = int(ends[-1]) + 1
            alive = self._useful(starts[value[starts] > -np.inf], value, first, margin)

    def _useful(self, starts: Frames, value: Array, end: int, margin: float) -> Frames:
        """Starts that may still win at ``end`` or later."""
        if self.lead is None:
            return starts
        rivals = starts[starts <= end - min(self.shortest, self.frames)][-RIVALS:]
        behind = value[rivals] - value[starts][:, None] - self.lead(starts, rivals) - margin
        # Of two starts that are always equal the later one stays.
        beaten = np.where(rivals > starts[:, None], behind >= 0, behind > 0)
        return starts[~beaten.any(axis=1)]


def most_probable_cuts(lattice: Lattice) -> tuple[tuple[int, ...], float]:
    """The maximum a posteriori cuts when segment lengths are geometric (ALGORITHMS section 2).

    Maximises Σ_segments score + K log p + (T − K) log(1 − p) with p = 1 / expected length. Of segmentations
    worth the same, the one whose last segments start latest is taken.

    Returns:
        (0, …, T), where each segment starts and the last one ends, in frames; and the maximum.
    """
    value = np.full(lattice.frames + 1, -np.inf)
    value[0] = 0
    previous = np.zeros(lattice.frames + 1, np.intp)
    for block in lattice.blocks(value):
        before = value[block.starts]
        own = len(block.starts) - len(block.ends)
        for row, end in enumerate(block.ends):
            reached = before + block.scores[row]
            k = len(reached) - 1 - reached[::-1].argmax()  # the latest of equals
            value[end] = before[own + row] = reached[k]
            previous[end] = block.starts[k]
    cuts = [lattice.frames]
    while cuts[-1] > 0:
        cuts.append(int(previous[cuts[-1]]))
    return tuple(reversed(cuts)), float(value[-1]) + lattice.constant


def log_sums(lattice: Lattice) -> tuple[Array, Array]:
    """Forward and backward sums over all segmentations, in logs, for scores summed over a segment's models.

    Returns:
        (T + 1,) of the segmentations of frames 0…t−1, and of those of frames t…T−1, for each t.
    """
    before, after = np.full((2, lattice.frames + 1), -np.inf)
    before[0] = after[-1] = 0
    pairs = []
    for block in lattice.blocks(before, MARGIN):
        level = before[block.starts]
        own = len(block.starts) - len(block.ends)
        for row, end in enumerate(block.ends):
            reached = level + block.scores[row]
            most = reached.max()
            if most > -np.inf:
                before[end] = level[own + row] = most + np.log(np.exp(reached - most).sum())
        pairs.append((block.ends, block.starts))
    for ends, starts in reversed(pairs):
        scores = lattice.block(ends, starts).scores
        for row in range(len(ends) - 1, -1, -1):
            after[starts] = np.logaddexp(after[starts], scores[row] + after[ends[row]])
    return before, after
