"""Where in the demonstration the operator looks, and what is to be seen there: picture, scene, evidence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.message import Message

from imitate.demonstration import Demonstration
from imitate.tui.album import Album
from imitate.tui.moment import Moment, unseen
from imitate.tui.series import Series, distances
from imitate.tui.traces import Traces

RATE = 15
"""moments a second that are shown while it plays."""
VIEWS = ("scene", "distances", "along", "lists")
"""what there is room for, one after the other, on a screen that has not enough for all; "lists": for none."""


class Looking(Vertical):
    """The time that is looked at; all views follow it."""

    class Moved(Message):
        """Another time is looked at."""

    def __init__(self) -> None:
        super().__init__(id="looking", classes=VIEWS[0])
        self.frame = 0
        self.playing = False
        self._played = 0.0
        self._demonstration: Demonstration | None = None
        self._apart: Series | None = None
        self._along: Series | None = None
        self._album = Album()
        self._cuts: tuple[float, ...] = ()
        self._cut = -1

    def compose(self) -> ComposeResult:
        """The evidence as plots, and below it the moment."""
        yield Traces("cm from the hand to", id="distances", least=0.0)
        yield Traces("nats a frame: moves along with the hand (+) or stays (−)", id="along")
        yield Moment()

    def on_mount(self) -> None:
        """The clock by which it plays."""
        self.set_interval(1 / RATE, self._tick)

    @property
    def now(self) -> float:
        """The time that is looked at, seconds since the first frame."""
        d = self._demonstration
        return float(d.t[self.frame] - d.t[0]) if d else 0.0

    @property
    def seen(self) -> str:
        """In words, how far the hand is from each object, and what was not seen."""
        if self._demonstration is None or self._apart is None:
            return ""
        near = zip(self._apart.names, self._apart.values, strict=True)
        apart = [f"{name} {y[self.frame]:.1f}" for name, y in near if np.isfinite(y[self.frame])]
        gone = unseen(self._demonstration, self.frame)
        parts = [f"hand to {', '.join(apart)} cm"] if apart else []
        return "; ".join([*parts, *([f"not seen: {', '.join(gone)}"] if gone else [])])

    def show(
        self,
        demonstration: Demonstration,
        album: Album,
        along: Series | None,
        cuts: Sequence[float],
        cut: int,
    ) -> None:
        """Show a demonstration with its pictures, co-motion and boundaries (s), number ``cut`` selected."""
        if demonstration is not self._demonstration:
            self._demonstration, self.frame, self.playing = demonstration, 0, False
            self._apart = distances(demonstration)
        self._album, self._along, self._cuts, self._cut = album, along, tuple(cuts), cut
        self.draw()

    def draw(self) -> None:
        """Everything, as it is at the time that is looked at."""
        if self._demonstration is None:
            return
        self.query_one("#distances", Traces).show(self._apart, self._cuts, self._cut, self.now)
        self.query_one("#along", Traces).show(self._along, self._cuts, self._cut, self.now)
        self.query_one(Moment).show(self._demonstration, self.frame, self._album)

    def go(self, time: float) -> None:
        """Look at the frame nearest to a time, and stop there."""
        self.playing = False
        self._look(time)

    def step(self, frames: int, seconds: int) -> None:
        """Look some frames, or seconds, further on or back."""
        self.playing = False
        d = self._demonstration
        if d is None:
            return
        if frames:
            self._look(float(d.t[min(max(self.frame + frames, 0), len(d.t) - 1)] - d.t[0]))
        else:
            self._look(self.now + seconds)

    def play(self) -> None:
        """Play on from here, or from the beginning where it had ended; or stop."""
        d = self._demonstration
        self.playing = d is not None and not self.playing
        if d is not None:
            self._played = 0.0 if self.frame == len(d.t) - 1 else self.now

    def turn(self) -> None:
        """The next view, where there is room for one alone."""
        present = next(k for k, view in enumerate(VIEWS) if self.has_class(view))
        self.remove_class(VIEWS[present])
        self.add_class(VIEWS[(present + 1) % len(VIEWS)])

    def _tick(self) -> None:
        if self.playing and self.screen.is_current:
            self._played += 1 / RATE
            self._look(self._played)
            d = self._demonstration
            self.playing = d is not None and self.frame < len(d.t) - 1

    def _look(self, time: float) -> None:
        d = self._demonstration
        if d is None:
            return
        frame = int(np.argmin(np.abs(d.t - d.t[0] - time)))
        if frame != self.frame:
            self.frame = frame
            self.draw()
            self.post_message(self.Moved())
