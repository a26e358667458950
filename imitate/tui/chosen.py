"""What of the segments the operator chose, apart from what was found."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from imitate.skill import Segment

DOUBTED = "!"
"""stands at what is far less likely than what was found."""


@dataclass(frozen=True)
class Chosen:
    """What of a segment is the operator's.

    Attributes:
        human: whether anything is.
        start, end, abstraction: which of its values are.
        doubted: whether it is far less likely than what was found.
    """

    human: bool
    start: bool
    end: bool
    abstraction: bool
    doubted: bool

    @property
    def by(self) -> str:
        """Whose segment it is, in a word."""
        if not self.human:
            return "auto"
        return f"you {DOUBTED}" if self.doubted else "you"


def chosen_of(
    found: tuple[Segment, ...], segments: tuple[Segment, ...], doubted: Collection[int]
) -> tuple[Chosen, ...]:
    """Of each segment; a value is the operator's unless it is what was found, or what is ranked first."""
    times = {time for s in found for time in (s.start, s.end)}
    return tuple(
        Chosen(s.human, s.start not in times, s.end not in times, _is_own(found, s), k in doubted)
        for k, s in enumerate(segments)
    )


def _is_own(found: tuple[Segment, ...], s: Segment) -> bool:
    there = max(found, key=lambda f: min(f.end, s.end) - max(f.start, s.start), default=s)
    best = s.alternatives[0].abstraction if s.alternatives else s.abstraction
    return s.human and s.abstraction not in (there.abstraction, best)
