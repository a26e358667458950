"""Colour and depth pictures paired by their time stamps, as they stream past."""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Generic, TypeVar

T = TypeVar("T")
COLOUR, DEPTH = 0, 1
LATE = 500_000_000
"""ns by which a picture may arrive after a later one and still take its place."""
MOST = 48
"""pictures of one kind that wait at a time, should their stamps hardly advance."""


@dataclass(frozen=True)
class Stamped(Generic[T]):
    """Something of one of two kinds (0 colour, 1 depth) with its time in nanoseconds."""

    kind: int
    time: int
    held: T


@dataclass
class Tally:
    """What became of the pictures, as far as they were read.

    Attributes:
        seen: how many came, (colour, depth).
        spans: ns, first and last stamp of each, (colour, depth), where any came.
        paired: how many pairs.
        late: how many came too late, or with the stamp of another.
        astray: how many had stamps off their clock, (colour, depth); they are not among those seen.
        nearest: ns between the nearest colour and depth, as long as none were paired.
    """

    seen: list[int] = field(default_factory=lambda: [0, 0])
    spans: dict[int, tuple[int, int]] = field(default_factory=dict)
    paired: int = 0
    late: int = 0
    astray: list[int] = field(default_factory=lambda: [0, 0])
    nearest: int | None = None

    @property
    def left_out(self) -> float:
        """Share of the frames that could be, were each picture of the rarer kind in one, that are not."""
        most = min(seen + astray for seen, astray in zip(self.seen, self.astray, strict=True))
        return 1 - self.paired / most if most else 0.0

    def count(self, kind: int, time: int) -> None:
        """One more picture."""
        self.seen[kind] += 1
        first, last = self.spans.get(kind, (time, time))
        self.spans[kind] = (min(first, time), max(last, time))


def paired(
    pictures: Iterable[Stamped[T]], within: int, tally: Tally
) -> Iterator[tuple[Stamped[T], Stamped[T]]]:
    """(colour, depth) in order of time, each picture in one pair at most.

    Of all ways to pair what is waiting without crossing, the one with the least sum of gaps is taken, where a
    picture left alone costs as much as half of ``within``. At most the pictures of half a second wait.

    Args:
        pictures: in nearly any order.
        within: ns, the most between the two of a pair.
        tally: counts what is read.
    """
    waiting: tuple[list[Stamped[T]], list[Stamped[T]]] = ([], [])
    settled = [-(2**63), -(2**63)]
    newest = -(2**63)
    late = max(LATE, 4 * within)
    for picture in pictures:
        own = waiting[picture.kind]
        tally.count(picture.kind, picture.time)
        if picture.time <= settled[picture.kind] or any(picture.time == other.time for other in own):
            tally.late += 1
            continue
        insort(own, picture, key=lambda one: one.time)
        newest = max(newest, picture.time)
        oldest = min(kind[0].time for kind in waiting if kind)
        if newest - oldest > late or len(own) > MOST:
            until = newest - late // 2 if len(own) <= MOST else own[MOST // 2].time
            yield from _settle(waiting, settled, within, until, tally)
    yield from _settle(waiting, settled, within, 2**63, tally)


def _settle(
    waiting: tuple[list[Stamped[T]], list[Stamped[T]]],
    settled: list[int],
    within: int,
    until: int,
    tally: Tally,
) -> Iterator[tuple[Stamped[T], Stamped[T]]]:
    """The pairs before ``until``; they and the pictures left alone before it stop waiting."""
    steps = _aligned([one.time for one in waiting[0]], [one.time for one in waiting[1]], within)
    used = [0, 0]
    for i, j in steps:
        pair = [waiting[kind][k] for kind, k in enumerate((i, j)) if k is not None]
        if max(one.time for one in pair) >= until:
            break
        for one in pair:
            used[one.kind] += 1
            settled[one.kind] = one.time
        if len(pair) == 2:
            tally.paired += 1
            yield pair[0], pair[1]
    if not tally.paired:
        _note_nearest(waiting, tally)
    for kind in (COLOUR, DEPTH):
        del waiting[kind][: used[kind]]


def _aligned(a: list[int], b: list[int], within: int) -> list[tuple[int | None, int | None]]:
    """Indices in order of time, (i, j) for a pair, (i, None) or (None, j) for one left alone."""
    cost = [[(i + j) * within for j in range(len(b) + 1)] for i in range(len(a) + 1)]  # twice the cost
    for i in range(1, len(a) + 1):
        above, row = cost[i - 1], cost[i]
        for j in range(1, len(b) + 1):
            gap = abs(a[i - 1] - b[j - 1])
            best = min(above[j], row[j - 1]) + within
            row[j] = min(best, above[j - 1] + 2 * gap) if gap <= within else best
    steps: list[tuple[int | None, int | None]] = []
    i, j = len(a), len(b)
    while i or j:
        if i and j and cost[i][j] == cost[i - 1][j - 1] + 2 * abs(a[i - 1] - b[j - 1]):
            i, j = i - 1, j - 1
            steps.append((i, j))
        elif i and cost[i][j] == cost[i - 1][j] + within and (not j or a[i - 1] > b[j - 1]):
            i -= 1
            steps.append((i, None))
        elif j and cost[i][j] == cost[i][j - 1] + within:
            j -= 1
            steps.append((None, j))
        else:
            i -= 1
            steps.append((i, None))
    return steps[::-1]


def _note_nearest(waiting: tuple[list[Stamped[T]], list[Stamped[T]]], tally: Tally) -> None:
    gaps = [abs(one.time - other.time) for one in waiting[0] for other in waiting[1]]
    if gaps:
        tally.nearest = min(gaps) if tally.nearest is None else min(*gaps, tally.nearest)
