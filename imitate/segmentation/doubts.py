"""What speaks against segments: said, never forbidden.

The operator's may explain the motion far less well than those found; a carry may be too short to be one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from imitate.demonstration import Demonstration
from imitate.segmentation.abstraction import best_scores, score_under
from imitate.segmentation.segments import Score, frames_at, lattice_of, score_of
from imitate.settings import Segmentation
from imitate.skill import Abstraction, Segment

DOUBTFUL = 10.0
"""nats by which segments may explain less than those found before it is said: twice the 5 from which Kass &
Raftery (1995, section 3.2) call evidence very strong, as neighbouring frames' noise is not independent."""


@dataclass(frozen=True)
class Doubt:
    """Segments that explain the motion far less well than those found.

    Attributes:
        first, last: indices of the segments, both included.
        log_ratio: ln of how likely the motion is as decided, of what it is as found; negative.
        decided, found: what is compared, each in a word or two.
    """

    first: int
    last: int
    log_ratio: float
    decided: str
    found: str

    def __str__(self) -> str:
        """The whole, for the operator."""
        skills = f"skill {self.first + 1}" + (f"–{self.last + 1}" if self.last > self.first else "")
        times = f"e^{self.log_ratio:.0f} times as likely"
        return f"{skills}: the motion is {times} {self.decided} as {self.found}; kept, as you decided"


@dataclass(frozen=True)
class Hasty:
    """A carry that is shorter than a grasp takes.

    Attributes:
        index: of the segment.
        seconds: that it lasts.
        least: seconds that fingers take to close and to open.
        abstraction: of the segment.
    """

    index: int
    seconds: float
    least: float
    abstraction: Abstraction

    def __str__(self) -> str:
        """The whole, for the operator."""
        return (
            f"skill {self.index + 1}: {self.abstraction} lasts {self.seconds:.2f} s, and fingers take "
            f"{self.least:.2f} s to close and to open; it may be a push, or noise"
        )


def hasty(segments: Sequence[Segment], settings: Segmentation) -> tuple[Hasty, ...]:
    """The carries that are shorter than a grasp takes, in order."""
    return tuple(
        Hasty(k, s.end - s.start, settings.grasp, s.abstraction)
        for k, s in enumerate(segments)
        if s.abstraction.carried and s.end - s.start < settings.grasp
    )


def doubts(
    demonstration: Demonstration,
    found: Sequence[Segment],
    decided: Sequence[Segment],
    settings: Segmentation,
    limit: float = DOUBTFUL,
) -> tuple[Doubt, ...]:
    """Where ``decided`` explains the motion worse than ``found``, by more than ``limit`` nats; in order.

    Abstractions and boundaries are judged apart: an abstraction against the best one of the same frames, as
    ranked; boundaries by the search's own score, each segment under its best abstraction. Segments between
    two boundaries that both have in common are compared with those found there.
    """
    score = score_of(demonstration, settings)
    cuts, before = (
        frames_at(score.times, [*(s.start for s in some), some[-1].end]) for some in (decided, found)
    )
    said = _of_boundaries(score, cuts, before, settings)
    for k, segment in enumerate(decided):
        if segment.abstraction != _found_there(found, segment):
            said += _of_abstraction(score, cuts, k, segment, demonstration.object_names)
    return tuple(sorted((d for d in said if d.log_ratio < -limit), key=lambda d: (d.first, d.last)))


def _of_boundaries(
    score: Score, cuts: Sequence[int], before: Sequence[int], settings: Segmentation
) -> list[Doubt]:
    each = lattice_of(score, settings).cost + score.prior

    def worth(some: Sequence[int]) -> float:
        pairs = [(a, max(b, a + 1)) for a, b in pairwise(some)]
        return sum(each + best_scores(score.evidence(np.array([a]), np.array([b]))).item() for a, b in pairs)

    def words(some: Sequence[int]) -> str:
        times = [f"{score.times[cut]:.2f}" for cut in some[1:-1]]
        return f"cut at {' and '.join(times)} s" if times else "uncut"

    said = []
    for low, high in pairwise(sorted({*cuts} & {*before})):
        here, there = ([cut for cut in some if low <= cut <= high] for some in (cuts, before))
        if here != there:
            first = cuts.index(low)
            ratio = worth(here) - worth(there)
            said.append(Doubt(first, first + len(here) - 2, ratio, words(here), words(there)))
    return said


def _of_abstraction(
    score: Score, cuts: Sequence[int], k: int, segment: Segment, names: Sequence[str]
) -> list[Doubt]:
    known = {other.abstraction: other.log_likelihood for other in segment.alternatives}
    if not known:
        return []
    chosen, best = segment.abstraction, segment.alternatives[0]
    if chosen not in known:
        between = score.between(cuts[k], max(cuts[k + 1], cuts[k] + 1))
        known[chosen] = score_under(between, chosen, names).item()
    ratio = known[chosen] - best.log_likelihood
    return [Doubt(k, k, ratio, f"for {chosen}", f"for {best.abstraction}")]


def _found_there(found: Sequence[Segment], segment: Segment) -> Abstraction:
    """The abstraction of the segment found that has most of a segment's time."""
    return max(found, key=lambda s: min(s.end, segment.end) - max(s.start, segment.start)).abstraction
