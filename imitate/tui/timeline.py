"""The segments of a demonstration as bands along time."""

from __future__ import annotations

from itertools import pairwise

from textual.content import Content
from textual.widget import Widget

from imitate.skill import Segment
from imitate.tui.state import Interval
from imitate.tui.words import change_in_words

BANDS = ("primary", "success", "accent", "warning", "secondary")


class Timeline(Widget):
    """Each band says its number and abstraction, so that colour only helps.

    ▲ is the selected boundary, ░ where with 90 % probability the motion changes.
    """

    def __init__(self) -> None:
        super().__init__()
        self._segments: tuple[Segment, ...] = ()
        self._changes: tuple[Interval, ...] = ()
        self._selected = self._boundary = -1

    def show(
        self, segments: tuple[Segment, ...], selected: int, boundary: int, changes: tuple[Interval, ...]
    ) -> None:
        """Show ``segments``, mark the selected one and the boundary at the end of segment ``boundary``.

        Args:
            changes: from when to when the motion changes at each boundary, seconds; empty while not known.
        """
        self._segments, self._selected, self._boundary = segments, selected, boundary
        self._changes = changes
        self.refresh()

    def render(self) -> Content:
        """Three lines of bands and the line of the mark."""
        if not self._segments:
            return Content("")
        width = self.size.width
        ends = columns(self._segments, width)
        lines = [Content("").join(self._bands(ends, texts)) for texts in zip(*self._texts(), strict=True)]
        return Content("\n").join([*lines, self._mark(ends, width)])

    def _texts(self) -> list[tuple[str, str, str]]:
        return [
            (
                f"{'▸' if i == self._selected else ' '}{i + 1}{'  by you' if s.human else ''}",
                f" {', '.join(s.abstraction.relevant)}",
                f" in {s.abstraction.reference}",
            )
            for i, s in enumerate(self._segments)
        ]

    def _bands(self, ends: list[int], texts: tuple[str, ...]) -> list[Content]:
        cells = []
        shaded = self._shaded(ends[-1])
        for i, (end, text) in enumerate(zip(ends, texts, strict=True)):
            first = ends[i - 1] if i else 0
            band = end - first
            last = "│" if i < len(ends) - 1 else ""
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
        if column + len(label) + 2 > width:
            return Content(f"{label} ▲".rjust(column + 1))
        return Content(" " * column + f"▲ {label}")

    def _shaded(self, width: int) -> list[bool]:
        # A column is shaded where any of its time may hold a change.
        begin = self._segments[0].start
        column = (self._segments[-1].end - begin) / width
        edges = [begin + k * column for k in range(width + 1)]
        return [any(low < b and a < high for low, high in self._changes) for a, b in pairwise(edges)]


def columns(segments: tuple[Segment, ...], width: int) -> list[int]:
    """The column after each segment's band; every band has at least two where there is room."""
    first, duration = segments[0].start, segments[-1].end - segments[0].start
    ends = [round((s.end - first) / duration * width) for s in segments]
    for i in range(len(ends) - 1):
        ends[i] = min(max(ends[i], (ends[i - 1] if i else 0) + 2), width - 2 * (len(ends) - 1 - i))
    ends[-1] = width
    return ends
