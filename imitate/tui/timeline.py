"""The segments of a demonstration as bands along time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from textual.content import Content
from textual.events import Click
from textual.message import Message
from textual.widget import Widget

from imitate.skill import Segment
from imitate.tui.chosen import Chosen
from imitate.tui.state import Interval
from imitate.tui.words import change_in_words

BANDS = ("primary", "success", "accent", "warning", "secondary")


class Timeline(Widget):
    """Each band says its number and abstraction, so that colour only helps.

    ▼ is the time that is looked at, ▲ the selected boundary, ║ one that the operator chose, ░ where with 90 %
    probability the motion changes.
    """

    @dataclass
    class Pointed(Message):
        """The mouse points at a time, seconds since the first frame."""

        seconds: float

    def __init__(self) -> None:
        super().__init__()
        self._segments: tuple[Segment, ...] = ()
        self._changes: tuple[Interval, ...] = ()
        self._selected = self._boundary = -1
        self._chosen: tuple[Chosen, ...] = ()
        self._now, self._seen = 0.0, ""

    def show(
        self,
        segments: tuple[Segment, ...],
        selected: int,
        boundary: int,
        changes: tuple[Interval, ...],
        chosen: tuple[Chosen, ...],
    ) -> None:
        """Show ``segments``, mark the selected one and the boundary at the end of segment ``boundary``.

        Args:
            changes: from when to when the motion changes at each boundary, seconds; empty while not known.
            chosen: what of each segment the operator chose.
        """
        self._segments, self._selected, self._boundary = segments, selected, boundary
        self._changes, self._chosen = changes, chosen
        self.refresh()

    def point(self, now: float, seen: str) -> None:
        """Show which time is looked at, seconds since the first frame, with some words about it."""
        self._now, self._seen = now, seen
        self.refresh()

    def on_click(self, event: Click) -> None:
        """The time below the mouse."""
        if self._segments:
            self.post_message(
                self.Pointed(_time(self._segments, columns(self._segments, self.size.width), event.x))
            )

    def render(self) -> Content:
        """The line of the time, three lines of bands and the line of the boundary."""
        if not self._segments:
            return Content("")
        width = self.size.width
        ends = columns(self._segments, width)
        lines = [Content("").join(self._bands(ends, texts)) for texts in zip(*self._texts(), strict=True)]
        now = _marked(
            "▼", _column(self._segments, ends, self._now), f"{self._now:.2f} s  {self._seen}", width
        )
        return Content("\n").join([now, *lines, self._mark(ends, width)])

    def _texts(self) -> list[tuple[str, str, str]]:
        return [
            (
                f"{'▸' if i == self._selected else ' '}{i + 1}{'' if own.by == 'auto' else f'  by {own.by}'}",
                f" {', '.join(s.abstraction.relevant)}",
                f" in {s.abstraction.reference}",
            )
            for i, (s, own) in enumerate(zip(self._segments, self._chosen, strict=True))
        ]

    def _bands(self, ends: list[int], texts: tuple[str, ...]) -> list[Content]:
        cells = []
        shaded = self._shaded(ends[-1])
        for i, (end, text) in enumerate(zip(ends, texts, strict=True)):
            first = ends[i - 1] if i else 0
            band = end - first
            last = ("║" if self._chosen[i].end else "│") if i < len(ends) - 1 else ""
            colour = BANDS[i % len(BANDS)]
            weight = "bold " if i == self._selected else ""
            body = text[: max(0, band - len(last))].ljust(max(0, band - len(last))) + last
            body = "".join(
                "░" if sign == " " and not 0 < k < len(text) and shaded[first + k] else sign
                for k, sign in enumerate(body)
            )
            cells.append(Content.styled(body, f"{weight}$text-{colour} on ${colour}-muted"))
        return cells

    def _mark(self, ends: list[int], width: int) -> Content:
        if not 0 <= self._boundary < len(ends) - 1:
            return Content("")
        column = ends[self._boundary] - 1
        label = f"{self._segments[self._boundary].end:.2f} s"
        if self._boundary < len(self._changes):
            label += f", 90 %: {change_in_words(self._changes[self._boundary])}"
        return _marked("▲", column, label, width)

    def _shaded(self, width: int) -> list[bool]:
        # A column is shaded where any of its time may hold a change.
        begin = self._segments[0].start
        column = (self._segments[-1].end - begin) / width
        edges = [begin + k * column for k in range(width + 1)]
        return [any(low < b and a < high for low, high in self._changes) for a, b in pairwise(edges)]


def _marked(sign: str, column: int, label: str, width: int) -> Content:
    # The label goes where there is more room.
    after, before = max(width - column - 2, 0), max(column - 1, 0)
    if len(label.rstrip()) <= after or after >= before:
        return Content(f"{' ' * column}{sign} {label[:after]}")
    return Content(f"{label.rstrip()[:before]} {sign}".rjust(column + 1))


def _column(segments: tuple[Segment, ...], ends: list[int], time: float) -> int:
    """The column of a time, always within the band of its segment."""
    k = max((i for i, s in enumerate(segments) if s.start <= time), default=0)
    first, s = (ends[k - 1] if k else 0), segments[k]
    share = (time - s.start) / (s.end - s.start)
    return min(max(first + int(share * (ends[k] - first)), first), ends[k] - 1)


def _time(segments: tuple[Segment, ...], ends: list[int], column: int) -> float:
    """The time in the middle of a column."""
    k = min(sum(end <= column for end in ends), len(ends) - 1)
    first, s = (ends[k - 1] if k else 0), segments[k]
    return s.start + (column + 0.5 - first) / (ends[k] - first) * (s.end - s.start)


def columns(segments: tuple[Segment, ...], width: int) -> list[int]:
    """The column after each segment's band; every band has at least two where there is room."""
    first, duration = segments[0].start, segments[-1].end - segments[0].start
    ends = [round((s.end - first) / duration * width) for s in segments]
    for i in range(len(ends) - 1):
        ends[i] = min(max(ends[i], (ends[i - 1] if i else 0) + 2), width - 2 * (len(ends) - 1 - i))
    ends[-1] = width
    return ends
