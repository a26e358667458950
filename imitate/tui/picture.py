"""A picture in half blocks, two pixels a cell; one has a cursor that points at a pixel.

Drawn here and not by a picture library: the cursor has to know which pixel a cell shows, and those libraries
ask the terminal what it can do, which Textual owns by then.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.color import Color
from rich.color_triplet import ColorTriplet
from rich.segment import Segment
from rich.style import Style
from textual.binding import Binding
from textual.events import Click
from textual.geometry import Size
from textual.message import Message
from textual.reactive import reactive
from textual.strip import Strip
from textual.widget import Widget

Image = NDArray[np.uint8]

LEAP = 8
"""cells that a shifted arrow moves the cursor by."""


class Blocks(Widget):
    """An (H, W, 3) picture, red green blue, as large as fits; another one may follow."""

    def __init__(self, image: Image | None = None, id: str | None = None) -> None:
        super().__init__(id=id)
        self.image = np.zeros((2, 1, 3), np.uint8) if image is None else image
        self._scaled: Image = self.image[:2, :1]

    def show(self, image: Image) -> None:
        """Another picture."""
        if image is not self.image:
            self.image = image
            self.scale()

    def on_resize(self) -> None:
        """As large as fits now."""
        self.scale()

    def scale(self) -> None:
        """Scale anew."""
        columns, rows = fitting(self.image, self.size)
        self._scaled = np.asarray(
            cv2.resize(self.image, (columns, 2 * rows), interpolation=cv2.INTER_AREA), np.uint8
        )
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Row ``y`` of cells: the upper pixel is the block's colour, the lower one its background's."""
        return Strip(self.blocks(y)).adjust_cell_length(self.size.width, self.rich_style)

    def blocks(self, y: int) -> list[Segment]:
        """A cell each; none below the picture."""
        if 2 * y + 1 >= len(self._scaled):
            return []
        return [
            Segment("▀", Style.from_color(_colour(upper), _colour(lower)))
            for upper, lower in zip(*self._scaled[2 * y : 2 * y + 2], strict=True)
        ]


class Picture(Blocks, can_focus=True):
    """A picture in which arrows and the mouse move a cursor."""

    BINDINGS = [
        Binding(f"{prefix}{arrow},{letter}", f"move({dx * by}, {dy * by})", f"{words} {arrow}", show=False,
                id=f"picture.{words.replace(' ', '_')}_{arrow}", tooltip=f"The cursor {words} {arrow}")
        for prefix, by, words, letters in (("", 1, "one cell", "hjkl"), ("shift+", LEAP, "far", "HJKL"))
        for arrow, letter, dx, dy in zip(
            ("left", "down", "up", "right"), letters, (-1, 0, 0, 1), (0, 1, -1, 0), strict=True
        )
    ]  # fmt: skip

    cell = reactive((0, 0))
    """column and row of the cursor."""

    class Pointed(Message):
        """The cursor moved."""

    @property
    def pixel(self) -> tuple[int, int]:
        """(u, v) in the middle of the cell that the cursor is on: column and row of the picture."""
        rows, columns = self._scaled.shape[0] // 2, self._scaled.shape[1]
        height, width = self.image.shape[:2]
        column, row = self.cell
        return int((column + 0.5) * width / columns), int((row + 0.5) * height / rows)

    def point(self, u: int, v: int) -> None:
        """Put the cursor on a pixel."""
        rows, columns = self._scaled.shape[0] // 2, self._scaled.shape[1]
        height, width = self.image.shape[:2]
        self.cell = (u * columns // width, v * rows // height)

    def scale(self) -> None:
        """Scale anew and keep the cursor on its pixel."""
        u, v = self.pixel
        super().scale()
        self.point(u, v)

    def validate_cell(self, cell: tuple[int, int]) -> tuple[int, int]:
        """Inside the picture."""
        rows, columns = self._scaled.shape[0] // 2, self._scaled.shape[1]
        return min(max(cell[0], 0), columns - 1), min(max(cell[1], 0), rows - 1)

    def watch_cell(self) -> None:
        """Tell whoever shows what is under the cursor."""
        self.post_message(self.Pointed())

    def action_move(self, right: int, down: int) -> None:
        """Move the cursor by cells."""
        self.cell = (self.cell[0] + right, self.cell[1] + down)

    def on_click(self, event: Click) -> None:
        """The cursor goes where the mouse is."""
        self.cell = (event.x, event.y)

    def blocks(self, y: int) -> list[Segment]:
        """The picture's, and the cursor."""
        segments = super().blocks(y)
        column, row = self.cell
        if row == y and segments:
            dark = int(self._scaled[2 * y : 2 * y + 2, column].mean()) < 128
            segments[column] = Segment(
                "╋",
                Style(color="white" if dark else "black", bold=True)
                + Style(bgcolor=_colour(self._scaled[2 * y, column])),
            )
        return segments


def fitting(image: Image, size: Size) -> tuple[int, int]:
    """(columns, rows) of cells, twice as high as wide, that show a picture undistorted within ``size``."""
    height, width = image.shape[:2]
    columns = max(1, min(size.width, 2 * size.height * width // height))
    return columns, max(1, round(columns * height / width / 2))


def _colour(pixel: Image) -> Color:
    return Color.from_triplet(ColorTriplet(*pixel.tolist()))
