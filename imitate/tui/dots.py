"""Lines of braille dots, 2 × 4 a cell: every dot shows, in the colour of the last line through the cell.

Drawn here and not on the plots' canvas, where a line wipes out the dots of those before it in a cell.
"""

from __future__ import annotations

import cv2
import numpy as np
from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

from imitate.geometry import Array

WIDE, HIGH = 2, 4
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
_FINE = 4
"""binary digits after the point that OpenCV rounds a dot's place to."""
_FAR = 1e5


class Dots:
    """A picture of so many columns and rows of cells."""

    def __init__(self, columns: int, rows: int) -> None:
        self._cells = np.zeros((rows, columns), int)
        self._inks = np.zeros((rows, columns), int)
        self._styles: list[Style] = [Style.null()]
        self._words: dict[tuple[int, int], tuple[str, Style]] = {}

    @property
    def rows(self) -> int:
        """How many."""
        return len(self._cells)

    def line(self, points: Array, style: Style) -> None:
        """Joins points (N, 2), columns and rows with fractions; what is outside is left out."""
        rows, columns = self._cells.shape
        mask = np.zeros((rows * HIGH, columns * WIDE), np.uint8)
        places = np.clip(points * [WIDE, HIGH] - 0.5, -_FAR, _FAR)
        cv2.polylines(mask, [np.round(places * 2**_FINE).astype(np.int32)], False, 1, shift=_FINE)
        blocks = mask.reshape(rows, HIGH, columns, WIDE).transpose(0, 2, 1, 3)
        bits = (blocks * _BITS).sum(axis=(2, 3))
        self._styles.append(style)
        self._inks[bits > 0] = len(self._styles) - 1
        self._cells |= bits

    def words(self, text: str, column: int, row: int, style: Style) -> None:
        """Writes over the dots, as far as there is room."""
        rows, columns = self._cells.shape
        for k, letter in enumerate(text):
            if 0 <= column + k < columns and 0 <= row < rows:
                self._words[row, column + k] = letter, style

    def has_words(self, row: int, column: int, width: int) -> bool:
        """Whether something was written in any of these cells."""
        return any((row, column + k) in self._words for k in range(width))

    def cell(self, row: int, column: int) -> tuple[str, Style] | None:
        """Sign and style; None where nothing was drawn."""
        if (row, column) in self._words:
            return self._words[row, column]
        bits = int(self._cells[row, column])
        return (chr(0x2800 + bits), self._styles[self._inks[row, column]]) if bits else None

    def strip(self, row: int) -> Strip:
        """One row of cells."""
        blank = " ", Style.null()
        cells = [self.cell(row, column) or blank for column in range(self._cells.shape[1])]
        return Strip([Segment(sign, style) for sign, style in cells]).simplify()
