"""How sure the cuts are: forward–backward over all segmentations, not only the most probable one.

Two questions are answered. Whether there is a cut at a frame at all: over every number of segments and every
abstraction. And where the change from one skill to the next lies, given that these are the skills: over all
positions of all boundaries together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array, read_only
from imitate.segmentation.abstraction import log_sum, score_under, total_scores
from imitate.segmentation.changepoints import BLOCK, Frames, Lattice, log_sums
from imitate.segmentation.segments import Score, frames_at, lattice_of, score_of
from imitate.settings import Segmentation
from imitate.skill import Segment

REACH = 10.0
"""s from a boundary to the farthest place at which its change is looked for …"""
REACH_FRAMES = 1000
"""… but no more than these frames, which bounds memory."""


@dataclass(frozen=True)
class Posterior:
    """Where the change from one skill to the next lies.

    Attributes:
        times: (F,) seconds since the first frame, increasing.
        probability: (F,) of the change to lie there; sums to one.
    """

    times: Array
    probability: Array

    def __post_init__(self) -> None:
        for name in ("times", "probability"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def within(self, time: float, tolerance: float) -> float:
        """The probability of the change to lie within ``tolerance`` seconds of ``time``."""
        return float(self.probability[np.abs(self.times - time) <= tolerance + 1e-9].sum())

    def interval(self, mass: float = 0.9) -> tuple[float, float]:
        """From when to when the change lies with probability ``mass``, as much left out on either side."""
        below = np.cumsum(self.probability)
        tail = (1 - mass) / 2
        first, last = np.searchsorted(below, [tail, 1 - tail])
        return float(self.times[first]), float(self.times[min(last, len(self.times) - 1)])


@dataclass(frozen=True)
class Posteriors:
    """How sure a segmentation is.

    Attributes:
        times: (T,) of the frames that were cut, seconds since the first one.
        cut: (T,) probability that a segment starts at each frame, 0 at the first one. It counts cuts within a
            skill too, which are merged when skills are reported.
        boundaries: of each of the N − 1 boundaries between N segments.
    """

    times: Array
    cut: Array
    boundaries: tuple[Posterior, ...]

    def __post_init__(self) -> None:
        for name in ("times", "cut"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


def posteriors(
    demonstration: Demonstration, segments: Sequence[Segment], settings: Segmentation
) -> Posteriors:
    """How sure the boundaries between ``segments`` are, as found or as the operator has them.

    A boundary's posterior is that of the change itself, when what is held starts or stops to move. `segment`
    gives the rests beside that to the carry, so that its boundary may lie some ``rest_limit`` off.
    """
    score = score_of(demonstration, settings)
    return Posteriors(
        score.times,
        cut_probability(lattice_of(score, settings, total_scores))[:-1],
        changes(demonstration, segments, settings),
    )


def changes(
    demonstration: Demonstration, segments: Sequence[Segment], settings: Segmentation
) -> tuple[Posterior, ...]:
    """The posteriors of the boundaries alone, which take a small part of the time."""
    score = score_of(demonstration, settings)
    cuts = frames_at(score.times, [*(s.start for s in segments), segments[-1].end])
    return boundary_posteriors(score, cuts, segments, demonstration.object_names, settings)


def cut_probability(lattice: Lattice) -> Array:
    """(T + 1,) probability of a cut at each frame under all segmentations; 0 at either end.

    Args:
        lattice: whose scores are summed over all models of a segment.
    """
    before, after = log_sums(lattice)
    cut: Array = np.exp(before + after - before[-1])
    cut[[0, -1]] = 0
    return cut


def boundary_posteriors(
    score: Score,
    cuts: Sequence[int],
    segments: Sequence[Segment],
    names: Sequence[str],
    settings: Segmentation,
) -> tuple[Posterior, ...]:
    """Of each inner cut, given the abstractions of the segments in their order.

    Each cut is looked for between its neighbours as they are, at most `REACH` away; all cuts vary together.

    Args:
        cuts: N + 1 frames, (0, …, T).
    """
    lattice = lattice_of(score, settings)
    least = min(lattice.shortest, *np.diff(cuts).tolist())
    a_second = (len(score.times) - 1) / score.times[-1]
    places = _places(cuts, least, min(round(REACH * a_second), REACH_FRAMES))

    def worth(k: int) -> Array:
        """(E, S) log score of segment k between the places of its two cuts."""
        starts, ends = places[k], places[k + 1]
        rows = [
            score_under(score.evidence(starts, ends[i : i + BLOCK]), segments[k].abstraction, names)
            for i in range(0, len(ends), BLOCK)
        ]
        return np.where(ends[:, None] - starts >= least, np.concatenate(rows), -np.inf)

    before, after = [np.zeros(1)], [np.zeros(1)]
    for k in range(len(segments) - 1):
        before.append(log_sum(before[-1] + worth(k), axis=1))
    for k in range(len(segments) - 1, 0, -1):
        after.append(log_sum(after[-1][:, None] + worth(k), axis=0))
    found = zip(places[1:-1], before[1:], after[:0:-1], strict=True)
    return tuple(Posterior(score.times[at], _normalised(b + a)) for at, b, a in found)


def _places(cuts: Sequence[int], least: int, reach: int) -> list[Frames]:
    inner = [
        np.arange(max(before + least, cut - reach), min(after - least, cut + reach) + 1)
        for (before, cut), after in zip(pairwise(cuts), cuts[2:], strict=False)
    ]
    return [np.array(cuts[:1]), *inner, np.array(cuts[-1:])]


def _normalised(logs: Array) -> Array:
    """Probabilities; all equal where the score allows none."""
    if logs.max() == -np.inf:
        return np.full(len(logs), 1 / len(logs))
    shares = np.exp(logs - logs.max())
    return np.asarray(shares / shares.sum())
