"""Observe: a recording is tracked in a child process, and can be looked at as it was seen."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from textual import on, work
from textual.binding import Binding
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import ProgressBar, Static

from imitate.demonstration import HAND
from imitate.errors import ImitateError
from imitate.tui.engine import Engine
from imitate.tui.fingers import FingersScreen
from imitate.tui.intents import Wear
from imitate.tui.notes import ConfirmScreen
from imitate.tui.overlay import Overlay
from imitate.tui.sighting import Image, Sighting
from imitate.tui.state import State
from imitate.tui.step import StepScreen
from imitate.tui.track_rows import TrackRows
from imitate.tui.words import losses_in_words


class ObserveScreen(StepScreen):
    """The picture with what was found in it, and when each body was seen; why, where observing fails."""

    STEP = "observe"
    HELP = (
        "Observe: the pictures of the recording are turned into pose trajectories. First the table, the "
        "objects and the hand's coloured fingers are found in the first pictures, then they are tracked: "
        "each has a line around it, its name, and the way that it came in the last 1.5 s. Below stands for "
        "each how sure the tracker is of it: how many of its pixels agree, and how much of it is to be seen. "
        "Along time the blocks are as high as that is; ✗ is where it was lost and the demonstration has no "
        "pose. Left and right look at another frame, with shift a second further; after the last one the "
        "newest is followed. Where the fingers have other colours than the settings say, f shows the first "
        "picture to point at them. Esc goes back; left before it is done, it is to be observed again."
    )
    BINDINGS = [
        Binding("left,h", "seek(-1)", "frame", id="observe.back", priority=True, key_display="←→",
                tooltip="Look at another frame; h and l do the same, shift goes by a second"),
        Binding("right,l", "seek(1)", "frame", id="observe.on", priority=True, show=False),
        Binding("shift+left,H", "leap(-1)", "second back", id="observe.leap_back", priority=True, show=False),
        Binding("shift+right,L", "leap(1)", "second on", id="observe.leap_on", priority=True, show=False),
        Binding("f", "fingers", "finger colours", id="observe.fingers",
                tooltip="Point at the two fingers in the first picture, and observe anew"),
        Binding("r", "retry", "again", id="observe.retry", tooltip="Observe anew"),
    ]  # fmt: skip

    def __init__(self, state: State, engine: Engine) -> None:
        super().__init__(state)
        self._engine = engine
        self._chosen: int | None = None  # the frame that is looked at; None for the newest
        self._asked: Path | None = None  # the recording whose first picture was asked for

    @property
    def frame(self) -> int:
        """The frame that is shown: of those with a picture the last one up to the one that was chosen."""
        sighting = self.state.sighting
        if sighting is None:
            return 0
        chosen = len(sighting) - 1 if self._chosen is None else self._chosen
        return sighting.pictured(chosen) or 0

    def body(self) -> Iterable[Widget]:
        """Picture, words and the bar; a row for each body."""
        yield Horizontal(
            Overlay(),
            VerticalScroll(
                Static(id="doing", markup=False),
                ProgressBar(total=100, show_eta=False),
                id="said",
                can_focus=False,
            ),
            id="observing",
        )
        yield VerticalScroll(TrackRows(), id="bodies")

    def on_screen_resume(self) -> None:
        """What a notice said of losses is shown here."""
        super().on_screen_resume()
        self.app.clear_notifications()

    def draw(self) -> None:
        """As far as it is, or why it goes no further."""
        super().draw()
        state, sighting = self.state, self.state.sighting
        self.query_one("#doing", Static).update(_words(state))
        bar = self.query_one(ProgressBar)
        bar.display = not state.unseen and state.demonstration is None
        bar.update(progress=100 * state.observed)
        self.query_one("#bodies").display = sighting is not None
        if sighting is not None:
            self._draw_frame(sighting)
        elif state.source:
            self._wait(state.source)

    def _wait(self, source: Path) -> None:
        """Nothing is tracked yet: the first picture, without what an observation before this one found."""
        overlay, self._chosen = self.query_one(Overlay), None
        overlay.bare(overlay.image)
        if source != self._asked:
            self._asked, overlay.display = source, False
            self._read_first(source)

    @work(thread=True, exclusive=True, group="first", exit_on_error=False)
    def _read_first(self, source: Path) -> None:
        try:
            image = self._engine.first_picture(source, self.state.settings)
        except ImitateError:
            return  # observing says it
        self.app.call_from_thread(self._show_first, source, image)

    def _show_first(self, source: Path, image: Image) -> None:
        overlay = self.query_one(Overlay)
        if self.state.sighting is None and source == self.state.source:
            overlay.display = True
            overlay.bare(image)

    def _draw_frame(self, sighting: Sighting) -> None:
        overlay = self.query_one(Overlay)
        overlay.display = True
        overlay.frame(sighting, self.frame)
        shown = self.state.demonstration
        kept = (HAND, *shown.object_names) if shown else sighting.cast.names
        left_out = frozenset(sighting.cast.names) - set(kept)
        self.query_one(TrackRows).show(sighting, self.frame, left_out)

    def action_seek(self, by: int) -> None:
        """To the next frame that has a picture, or the one before."""
        sighting = self.state.sighting
        if sighting is None:
            return
        frame = self.frame + by
        while 0 <= frame < len(sighting) and not sighting.pictures[frame]:
            frame += by
        self._look(sighting, frame)

    def action_leap(self, by: int) -> None:
        """By so many seconds."""
        sighting = self.state.sighting
        if sighting is not None:
            self._look(sighting, sighting.at(float(sighting.t[self.frame]) + by))

    @on(TrackRows.Sought)
    def _sought(self, message: TrackRows.Sought) -> None:
        if self.state.sighting is not None:
            self._look(self.state.sighting, message.frame)

    def _look(self, sighting: Sighting, frame: int) -> None:
        self._chosen = max(frame, 0) if frame < len(sighting) - 1 else None
        self.draw()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Again where it failed, other frames where there are any, other colours while nothing learns."""
        if action == "retry":
            return bool(self.state.unseen)
        if action in ("seek", "leap"):
            return self.state.sighting is not None
        if action == "fingers":
            return not self.state.running
        return super().check_action(action, parameters)

    def action_retry(self) -> None:
        """Observe anew with the same colours."""
        worn = self.state.settings.perception
        self._anew(worn.left_finger, worn.right_finger)

    @work(exclusive=True, group="fingers")
    async def action_fingers(self) -> None:
        """Point at the fingers in the first picture."""
        if self.state.source is None:
            return
        try:
            image = self._engine.first_picture(self.state.source, self.state.settings)
        except ImitateError as error:
            self.notify(str(error), title="✗", severity="error", markup=False)
            return
        picked = await self.app.push_screen_wait(FingersScreen(image))
        if picked and await self._may_begin_anew():
            self._anew(*picked)

    async def _may_begin_anew(self) -> bool:
        if not (self.state.decisions or self.state.progress.skills):
            return True
        question = (
            "Observe anew with these colours? The skills are then cut anew, without your decisions in "
            "Review. A session that was learned stays in its file."
        )
        return await self.app.push_screen_wait(ConfirmScreen(question))

    def _anew(self, left: str, right: str) -> None:
        self._chosen = None
        self.post_message(Wear(left, right))


def _words(state: State) -> Content:
    """What is being done, what was seen, or why it could not be."""
    if state.unseen:
        return Content.assemble(("✗ ", "bold $text-error"), state.unseen)
    worn = state.settings.perception
    fingers = f"Left finger {_worn(worn.left_finger)}, right finger {_worn(worn.right_finger)}."
    if state.demonstration is None:
        return Content(f"{_doing(state.sighting)}\n\n{fingers}\n")
    demonstration = state.demonstration
    lost = losses_in_words(state.sighting, demonstration) if state.sighting else ""
    said = " ".join([lost or "Nothing was lost.", *(f"Of the recording: {note}." for note in state.notes)])
    sign = ("▲ ", "bold $text-warning") if lost or state.notes else ("✓ ", "bold $text-success")
    seen = f"Tracked: {len(demonstration.t)} frames, {demonstration.duration:.1f} s."
    return Content.assemble(sign, f"{seen} {said}\n\n{fingers}")


def _doing(sighting: Sighting | None) -> str:
    if sighting is None:
        return "Finding the table, the hand and the objects in the first pictures."
    return f"Tracking the hand and the objects: frame {len(sighting)} of {sighting.count}."


def _worn(colour: str) -> str:
    return f"at pixel {colour} of the first picture" if "," in colour else colour
