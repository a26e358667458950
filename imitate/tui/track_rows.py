"""Of the hand and each object: how sure the tracker is of it, and when in the recording it was seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from textual.content import Content
from textual.events import Click
from textual.message import Message
from textual.widgets import Static

from imitate.tui.overlay import PAPER
from imitate.tui.sighting import Sighting
from imitate.tui.words import bar

HEIGHTS = "▁▂▃▄▅▆▇"
"""the highest leaves a gap to the row above."""
LOST, COMING = "✗", "·"
BAR = 8
NOW = BAR + 8
"""cells of a bar, and of it with its number."""
NAME, TOTAL = 12, 10
"""letters of a name, at most, and cells of the seconds lost."""


class TrackRows(Static):
    """The rows; a click on the strip asks for the frame there."""

    @dataclass
    class Sought(Message):
        """This frame is to be looked at."""

        frame: int

    def __init__(self) -> None:
        super().__init__(markup=False)
        self._shown: tuple[Sighting, int, frozenset[str]] | None = None

    def show(self, sighting: Sighting, frame: int, left_out: frozenset[str] = frozenset()) -> None:
        """Show the rows at a frame, see `track_rows`."""
        self._shown = sighting, frame, left_out
        self._draw()

    def on_resize(self) -> None:
        """The strips are as long as there is room."""
        self._draw()

    def on_click(self, event: Click) -> None:
        """The frame that the column under the mouse begins with."""
        if self._shown is None:
            return
        sighting = self._shown[0]
        before, strip = _columns(sighting, self.size.width)
        frame = -(-(event.x - before) * sighting.count // strip)
        if 0 <= frame < len(sighting):
            self.post_message(self.Sought(frame))

    def _draw(self) -> None:
        if self._shown and self.size.width:
            sighting, frame, left_out = self._shown
            self.update(track_rows(sighting, frame, self.size.width, left_out))


def track_rows(sighting: Sighting, frame: int, width: int, left_out: frozenset[str] = frozenset()) -> Content:
    """A line for each body, one above and, with the time of ``frame``, one below.

    Args:
        width: cells.
        left_out: bodies that could not be followed, and are in no demonstration.
    """
    before, strip = _columns(sighting, width)
    head = f"{'confidence':>{before - NOW + 10}}{'':{NOW - 10}}{'seen':<{strip}}{'lost':>{TOTAL}}"
    lines = [Content.styled(head[:width], "$text-muted")]
    seconds, ever = sighting.lost_seconds, np.any(sighting.lost, axis=0)
    for body, name in enumerate(sighting.cast.names):
        red, green, blue = sighting.cast.inks[body]
        total = "left out" if name in left_out else f"{seconds[body]:.2f} s"
        parts = [
            Content.styled(" ■ ", f"rgb({red},{green},{blue}) on {PAPER}"),
            Content(f"{name[:NAME]:<{before - NOW - 4}} "),
            _now(sighting, frame, body),
            _strip(sighting, body, strip),
            Content.styled(f"{total:>{TOTAL}}", "$text-error" if ever[body] else ""),
        ]
        lines.append(Content("").join(parts))
    return Content("\n").join([*lines, _mark(sighting, frame, before, strip)])


def signs(sighting: Sighting, body: int, width: int) -> str:
    """A sign for each of ``width`` stretches of the recording: ✗ where the body was lost in any frame.

    Else a block as high as the least confidence; · where it is not tracked yet.
    """
    found = []
    lost, confidence = sighting.lost[:, body], sighting.confidence[:, body]
    for column in range(width):
        first = column * sighting.count // width
        frames = slice(first, max((column + 1) * sighting.count // width, first + 1))
        if not len(lost[frames]):
            found.append(COMING)
        elif lost[frames].any():
            found.append(LOST)
        else:
            found.append(HEIGHTS[min(int(confidence[frames].min() * len(HEIGHTS)), len(HEIGHTS) - 1)])
    return "".join(found)


def _columns(sighting: Sighting, width: int) -> tuple[int, int]:
    """Cells before the strip, and those of it."""
    before = 3 + max(len(name[:NAME]) for name in sighting.cast.names) + 1 + NOW
    return before, max(width - before - TOTAL, 4)


def _now(sighting: Sighting, frame: int, body: int) -> Content:
    if sighting.lost[frame, body]:
        return Content.styled(f"{LOST} lost".ljust(NOW), "bold $text-error")
    sure = float(sighting.confidence[frame, body])
    return Content(f"{bar(sure, BAR)} {100 * sure:3.0f} %".ljust(NOW))


def _strip(sighting: Sighting, body: int, width: int) -> Content:
    parts = [
        Content.styled(sign, {LOST: "bold $text-error", COMING: "$text-disabled"}.get(sign, "$text-success"))
        for sign in signs(sighting, body, width)
    ]
    return Content("").join(parts)


def _mark(sighting: Sighting, frame: int, before: int, width: int) -> Content:
    column = before + min(frame * width // max(sighting.count, 1), width - 1)
    label = f"{sighting.t[frame] - sighting.t[0]:.2f} s"
    if column + len(label) + 2 > before + width:
        return Content(f"{label} ▲".rjust(column + 1))
    return Content(" " * column + f"▲ {label}")
