"""A picture in half blocks, and over it, in lines of braille dots, what was found in it."""

from __future__ import annotations

import numpy as np
from rich.color import Color
from rich.segment import Segment
from rich.style import Style

from imitate.geometry import Array
from imitate.tui.dots import Dots
from imitate.tui.picture import Blocks, Image
from imitate.tui.sighting import Ink, Sighting

LOST: Ink = (255, 80, 80)
PAPER = "#000000"
"""behind names and signs: they are read over any picture."""
DIM = 0.5
"""of the picture's brightness where a line is drawn over it."""
BEHIND = 1.5
"""s of its way that a body draws behind it."""


class Overlay(Blocks):
    """One frame: each body's outline, its name, and the way that it came."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[Sighting, int] | None = None
        self._dots = Dots(1, 1)

    def bare(self, image: Image) -> None:
        """Show a picture in which nothing was found yet."""
        self._shown = None
        self.show(image)
        self.refresh()

    def frame(self, sighting: Sighting, number: int) -> None:
        """Show a frame that has a picture, and what was found in it."""
        before, self._shown = self._shown, (sighting, number)
        if before is None or before[1] != number or before[0].cast is not sighting.cast:
            self.show(sighting.picture(number))

    def scale(self) -> None:
        """Scale and draw anew."""
        super().scale()
        if self._shown and self.size.area:
            self._draw(*self._shown)

    def blocks(self, y: int) -> list[Segment]:
        """A cell each, with what is drawn over it."""
        segments = super().blocks(y)
        for column in range(len(segments) if self._shown else 0):
            if drawn := self._dots.cell(y, column):
                sign, style = drawn
                behind = self._scaled[2 * y : 2 * y + 2, column].mean(axis=0) * DIM
                paper = Style(bgcolor=Color.from_rgb(*behind.astype(int).tolist()))
                segments[column] = Segment(sign, paper + style)
        return segments

    def _draw(self, sighting: Sighting, frame: int) -> None:
        rows, columns = self._scaled.shape[0] // 2, self._scaled.shape[1]
        self._dots, room, lost = Dots(columns, rows), np.array([columns, rows]), 0
        for body, name in enumerate(sighting.cast.names):
            ink = sighting.cast.inks[body]
            if sighting.lost[frame, body]:
                self._words(f"✗ {name} lost", 0, lost, LOST)
                lost += 1
                continue
            rings = [room * ring for ring in sighting.outlines(frame, body)]
            ways = [room * way for way in sighting.way(frame, body, BEHIND)]
            for line in [*(way for way in ways if np.ptp(way, axis=0).max() > 1), *rings]:
                self._dots.line(line, Style(color=Color.from_rgb(*ink)))
            if rings:
                self._label(name, np.concatenate(rings), ink, above=body == 0)

    def _label(self, name: str, ring: Array, ink: Ink, above: bool) -> None:
        # The hand comes from above: its name stands over it, the objects' below them.
        rows, columns = self._scaled.shape[0] // 2, self._scaled.shape[1]
        row = int(np.floor(ring[:, 1].min())) - 1 if above else int(np.ceil(ring[:, 1].max()))
        column = round(float(ring[:, 0].mean()) - len(name) / 2)
        column = min(max(column, 0), max(columns - len(name), 0))
        free = [k for k in range(rows) if not self._dots.has_words(k, column, len(name))]
        if free:
            self._words(name, column, min(free, key=lambda k: abs(k - row)), ink)

    def _words(self, text: str, column: int, row: int, ink: Ink) -> None:
        self._dots.words(text, column, row, Style(color=Color.from_rgb(*ink), bgcolor=PAPER, bold=True))
