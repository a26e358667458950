"""Observe: a recording is tracked in a child process."""

from __future__ import annotations

from collections.abc import Iterable

from textual.containers import Vertical
from textual.widget import Widget
from textual.widgets import ProgressBar, Static

from imitate.tui.step import StepScreen


class ObserveScreen(StepScreen):
    """A progress bar; the review follows by itself."""

    STEP = "observe"
    HELP = (
        "Observe: the pictures of the recording are turned into pose trajectories. First the table, the "
        "blocks and the hand's coloured fingers are found in the first picture, then they are tracked. "
        "Esc goes back and leaves it."
    )

    def body(self) -> Iterable[Widget]:
        """Words and the bar."""
        yield Vertical(
            Static("Finding the table, the hand and the objects, and tracking them.", id="doing"),
            ProgressBar(total=100, show_eta=False),
            id="observing",
        )

    def draw(self) -> None:
        """As far as it is."""
        super().draw()
        self.query_one(ProgressBar).update(progress=100 * self.state.observed)
