"""How well a segmentation agrees with the right one: where it cuts, and what it takes to matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from imitate.skill import Abstraction, Segment

TOLERANCE = 0.5
"""s; how far a boundary may lie from the right one (issue 4: the change at 8.6 s ± 0.5 s)."""


@dataclass(frozen=True)
class Metrics:
    """Agreement of a segmentation with the truth.

    Attributes:
        tolerance: seconds, of boundaries.
        found, true: how many boundaries between segments each of the two has.
        matched: pairs of one each, no further apart than the tolerance; as many as there can be.
        worst: seconds, the largest distance within a pair; 0 without pairs.
        time_share: share of the time in which both name the same abstraction.
        segments: how many the truth has.
        segments_right: of these, how many have their abstraction in the found one that overlaps most.
    """

    tolerance: float
    found: int
    true: int
    matched: int
    worst: float
    time_share: float
    segments: int
    segments_right: int

    @property
    def precision(self) -> float:
        """Share of the boundaries found that are right; 1 where none was found."""
        return self.matched / self.found if self.found else 1.0

    @property
    def recall(self) -> float:
        """Share of the right boundaries that were found; 1 where there is none."""
        return self.matched / self.true if self.true else 1.0


def compare(found: Sequence[Segment], truth: Sequence[Segment], tolerance: float = TOLERANCE) -> Metrics:
    """Compares two segmentations of one demonstration, each in order and at least one segment long.

    An abstraction is right when its reference and its set of relevant bodies are. Time that only one of the
    two covers counts as wrong.
    """
    pairs = _pairs([s.end for s in found[:-1]], [s.end for s in truth[:-1]], tolerance)
    right = sum(_overlap(a, b) for a in found for b in truth if _same(a.abstraction, b.abstraction))
    whole = max(found[-1].end, truth[-1].end) - min(found[0].start, truth[0].start)
    main = [max(found, key=lambda s, t=t: _overlap(s, t)) for t in truth]  # type: ignore[misc]
    return Metrics(
        tolerance=tolerance,
        found=len(found) - 1,
        true=len(truth) - 1,
        matched=len(pairs),
        worst=max((abs(a - b) for a, b in pairs), default=0.0),
        time_share=right / whole,
        segments=len(truth),
        segments_right=sum(
            _overlap(s, t) > 0 and _same(s.abstraction, t.abstraction)
            for s, t in zip(main, truth, strict=True)
        ),
    )


def _pairs(found: Sequence[float], true: Sequence[float], tolerance: float) -> list[tuple[float, float]]:
    """The most pairs within the tolerance: with both in order, taking each as early as possible."""
    pairs = []
    left, right = list(found), list(true)
    while left and right:
        if abs(left[0] - right[0]) <= tolerance:
            pairs.append((left.pop(0), right.pop(0)))
        elif left[0] < right[0]:
            left.pop(0)
        else:
            right.pop(0)
    return pairs


def _overlap(a: Segment, b: Segment) -> float:
    return max(min(a.end, b.end) - max(a.start, b.start), 0.0)


def _same(a: Abstraction, b: Abstraction) -> bool:
    return a.reference == b.reference and set(a.relevant) == set(b.relevant)
