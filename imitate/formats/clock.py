"""Times as files have them: the unit they count in, stamps that leave their clock, and steps of the clock."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from statistics import median
from typing import TypeVar

import numpy as np

from imitate.demonstration import LONGEST_GAP, span_in_words
from imitate.formats.mapping import TIMES
from imitate.geometry import Array

T = TypeVar("T")
Both = tuple[int, int]
"""ns of a message: its own stamp, 0 where it has none, and when it was logged."""
SECOND = 10**9
"""ns."""
ASTRAY = 1.0
"""s by which a stamp leaves those before and after it, to be no moment of theirs."""
STEPS_ASTRAY = 3.0
"""times the step before; and by so much."""
AHEAD = 8
"""stamps that are looked at to tell one that is off from a clock that was set; three of them may be off."""
LONG_GAP = 2.0
"""s between two samples, and ten times their usual step, from which on a gap is worth a word."""
NAMES = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
"""of the units of `mapping.TIMES`."""
MUCH_ASTRAY = 0.1
"""share of samples off their clock from which on none of it is believed."""
_EPOCH = (1e9, 4e9)
"""s since 1970 between which people record: 2001 to 2096."""
_SLOWEST = 0.5
"""s between samples that have such times; what counts since a start may lie in the same range."""


def epoch_unit(ticks: Array) -> str | None:
    """The unit (`mapping.TIMES`) in which times (N,) count since 1970; None where they do not."""
    middle, step = float(np.median(ticks)), usual_step(ticks)
    units = (unit for unit, s in TIMES.items() if _EPOCH[0] <= middle * s < _EPOCH[1])
    return next((unit for unit in units if step * TIMES[unit] < _SLOWEST), None)


def usual_step(ticks: Array) -> float:
    """The middle one of the steps between times (N,), whichever way they go."""
    return float(np.median(np.abs(np.diff(ticks)))) if len(ticks) > 1 else 0.0


def faster_unit(step: float) -> str:
    """The unit in which ``step`` ticks between two frames make a usual rate."""
    return next((unit for unit in ("ms", "us") if step * TIMES[unit] < 1), "ns")


def on_one_clock(
    samples: Iterable[T], time: Callable[[T], float], astray: Callable[[T], None], second: float = 1.0
) -> Iterator[T]:
    """The samples but for single ones whose stamps leave those before and after them, as they stream past.

    A stamp is off where it differs from the one before by more than `ASTRAY`, and most of those that follow
    go on from the one before. A clock that is set, or a pause, goes on from the new stamp, and is left.

    Args:
        samples: in the order in which they were taken; a few are read ahead.
        time: of a sample.
        astray: hears of those left out.
        second: in the unit of ``time``.
    """
    source, ahead = iter(samples), deque[T]()
    before: float | None = None
    step = 0.0
    while True:
        ahead.extend(islice(source, AHEAD + 1 - len(ahead)))
        if not ahead:
            return
        one = ahead.popleft()
        now, far = time(one), max(ASTRAY * second, STEPS_ASTRAY * step)
        if before is None and len(ahead) > 1 and abs(time(ahead[1]) - time(ahead[0])) <= far:
            before = time(ahead[0])  # the first is off where the next two lie together elsewhere
        if (
            before is not None
            and abs(now - before) > far
            and _goes_on(before, now, [*map(time, ahead)], step)
        ):
            astray(one)
            continue
        step, before = 0.0 if before is None else abs(now - before), now
        yield one


def _goes_on(before: float, now: float, after: Sequence[float], step: float) -> bool:
    """Whether what comes ``after`` goes on from the stamp before; the last one of many is not believed."""
    if not after:
        return step > 0
    middle = median(after)
    return abs(middle - before) < abs(middle - now)


def whose_clock(streams: dict[str, Sequence[Both]], notes: list[str]) -> int:
    """Which of the two times holds for all streams: 0 their stamps, 1 the log's.

    The stamps, unless those of a stream are missing or of another clock than another's.

    Args:
        streams: topic → times of its messages, or of the first of them.
        notes: gets why it is the log's.
    """
    without = [topic for topic, times in streams.items() if unstamped(times)]
    why = ""
    if without:
        why = f"{', '.join(without)} {'has' if len(without) == 1 else 'have'} no stamps"
    else:
        own, logged = (_apart(streams, clock) for clock in (0, 1))
        if own > LONGEST_GAP > logged:
            why = f"{', '.join(streams)} are stamped by two clocks, {span_in_words(own)} apart"
    if why:
        note = f"{why}: the log's times are used"
        notes += [note] if note not in notes else []
    return 1 if why else 0


def unstamped(times: Sequence[Both]) -> bool:
    """Whether most of the messages have no stamps; a simulation's clock may start at 0."""
    return bool(times) and 2 * sum(stamp != 0 for stamp, _ in times) <= len(times)


def _apart(streams: dict[str, Sequence[Both]], clock: int) -> float:
    middles = [median(times[clock] for times in stream) for stream in streams.values() if stream]
    return (max(middles) - min(middles)) / SECOND if middles else 0.0


def astray_note(what: str, astray: int, of: int, where: str = "") -> str:
    """What `on_one_clock` left out, in words; ``what`` are stamped, plural."""
    off = f"stamped more than {ASTRAY:g} s off those before and after"
    return f"{astray} of {of} {what} {'are' if astray > 1 else 'is'} left out: {off}{where}"


def gaps_in_words(t: Array) -> list[str]:
    """Gaps in times (T,) seconds, increasing, that are worth a word: the longest, and how many there are."""
    steps = np.diff(t)
    if not len(steps):
        return []
    long = steps > max(LONG_GAP, 10 * float(np.median(steps)))
    if not long.any():
        return []
    k = int(np.argmax(steps))
    others = f", the longest of {int(long.sum())} such gaps" if long.sum() > 1 else ""
    where = f"from {t[k] - t[0]:.6g} s on{others}"
    return [
        f"{span_in_words(steps[k])} pass without a frame, {where}: taken as one straight motion. "
        "Where it was a pause, cut it out"
    ]
