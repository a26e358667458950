"""What speaks for the segments: a line for each object along the demonstration, with its boundaries.

Its columns are the timeline's, so that what happens at a time stands below that time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imitate.geometry import Array
from imitate.tui.drawing import Drawing
from imitate.tui.series import Series, letters
from imitate.tui.timeline import BANDS

LETTERS = 5
"""times that an object's letter stands on its line, so that colour only helps."""


class Traces(Drawing):
    """Lines with their objects' letters; ▲ the selected boundary, ▼ the time that is looked at."""

    def __init__(self, words: str, id: str, least: float | None = None) -> None:
        super().__init__(id=id)
        self._words, self._least = words, least
        self._shown: tuple[Series, Sequence[float], int, float] | None = None

    def show(self, series: Series | None, cuts: Sequence[float], at: int, now: float) -> None:
        """Draw these; the cut (s) number ``at`` is the selected one, ``now`` (s) what is looked at."""
        self._shown = (series, cuts, at, now) if series else None
        self.redraw()

    def draw(self) -> None:
        """Title, scale, boundaries, lines, letters, time."""
        self.dots.words(self._words, 0, 0, self.ink("text-muted"))
        if self._shown is None:
            return
        series, cuts, at, now = self._shown
        values = np.concatenate(series.values)
        low = float(np.nanmin(values)) if self._least is None else self._least
        high = max(float(np.nanmax(values)), low + 1e-3)
        self._range = low, high, float(series.t[-1])
        for i, cut in enumerate(cuts):
            self._upright(cut, "▲" if i == at else "", "foreground" if i == at else "text-disabled", -1)
        if low < 0 < high:
            self._line(np.array([0.0, series.t[-1]]), np.zeros(2), "text-disabled")
        column = len(self._words) + 2
        for i, (name, letter) in enumerate(zip(series.names, letters(series.names), strict=True)):
            colour = BANDS[i % len(BANDS)]
            self._line(series.t, series.values[i], colour)
            self._letters(series, i, letter, colour)
            self.dots.words(f"{letter} {name}", column, 0, self.ink(colour))
            column += len(name) + 4
        for value, row in ((high, 1), (low, self.size.height - 1)):
            self.dots.words(f"{value:.0f}", 0, row, self.ink("text-muted"))
        self._upright(now, "▼", "text-warning", 1)

    def _letters(self, series: Series, i: int, letter: str, colour: str) -> None:
        share = (np.arange(LETTERS) + (i + 0.5) / len(series.names)) / LETTERS
        at = np.searchsorted(series.t, share * series.t[-1]).clip(max=len(series.t) - 1)
        for column, row in self._cells(series.t[at], series.values[i][at]):
            if np.isfinite(row):
                self.dots.words(letter, int(column), int(row), self.ink(colour))

    def _upright(self, time: float, sign: str, colour: str, row: int) -> None:
        x = float(self._cells(np.array([time]), np.zeros(1))[0, 0])
        self.dots.line(np.array([[x, 1.0], [x, self.size.height]]), self.ink(colour))
        self.dots.words(sign, int(x), row % self.size.height, self.ink(colour))

    def _line(self, t: Array, y: Array, colour: str) -> None:
        known = np.isfinite(y)
        for run in np.split(np.arange(len(t)), np.flatnonzero(np.diff(known)) + 1):
            if known[run[0]]:
                self.dots.line(self._cells(t[run], y[run]), self.ink(colour))

    def _cells(self, t: Array, y: Array) -> Array:
        """(N, 2) columns and rows, below the title."""
        low, high, end = self._range
        width, rows = self.size.width - 1e-3, max(self.size.height - 1, 1)
        down = (high - np.clip(y, low, high)) / (high - low)
        return np.stack([t / end * width, 1.1 + down * (rows - 0.2)], axis=1)
