"""Observe: a recording is tracked in a child process."""

from __future__ import annotations

from collections.abc import Iterable

from textual import work
from textual.binding import Binding
from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import ProgressBar, Static

from imitate.errors import ImitateError
from imitate.tui.engine import Engine
from imitate.tui.fingers import FingersScreen
from imitate.tui.intents import Wear
from imitate.tui.state import State
from imitate.tui.step import StepScreen


class ObserveScreen(StepScreen):
    """A progress bar; the review follows by itself. Where observing fails, why, and what can be done."""

    STEP = "observe"
    HELP = (
        "Observe: the pictures of the recording are turned into pose trajectories. First the table, the "
        "objects and the hand's coloured fingers are found in the first picture, then they are tracked. "
        "Where the fingers have other colours than the settings say, f shows the first picture to point at "
        "them. Esc goes back and leaves it."
    )
    BINDINGS = [
        Binding("f", "fingers", "finger colours", id="observe.fingers",
                tooltip="Point at the two fingers in the first picture, and observe anew"),
        Binding("r", "retry", "again", id="observe.retry", tooltip="Observe anew"),
    ]  # fmt: skip

    def __init__(self, state: State, engine: Engine) -> None:
        super().__init__(state)
        self._engine = engine

    def body(self) -> Iterable[Widget]:
        """Words and the bar."""
        yield Vertical(Static(id="doing"), ProgressBar(total=100, show_eta=False), id="observing")

    def draw(self) -> None:
        """As far as it is, or why it goes no further."""
        super().draw()
        p, unseen = self.state.settings.perception, self.state.unseen
        self.query_one("#doing", Static).update(
            Content.assemble(("✗ ", "bold $text-error"), unseen)
            if unseen
            else Content(
                "Finding the table, the hand and the objects, and tracking them.\n"
                f"Left finger {_worn(p.left_finger)}, right finger {_worn(p.right_finger)}."
            )
        )
        bar = self.query_one(ProgressBar)
        bar.display = not unseen
        bar.update(progress=100 * self.state.observed)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Again only where it failed."""
        if action == "retry":
            return bool(self.state.unseen)
        return super().check_action(action, parameters)

    def action_retry(self) -> None:
        """Observe anew with the same colours."""
        worn = self.state.settings.perception
        self.post_message(Wear(worn.left_finger, worn.right_finger))

    @work(exclusive=True, group="fingers")
    async def action_fingers(self) -> None:
        """Point at the fingers in the first picture."""
        if self.state.source is None:
            return
        try:
            image = self._engine.first_picture(self.state.source)
        except ImitateError as error:
            self.notify(str(error), title="✗", severity="error", markup=False)
            return
        picked = await self.app.push_screen_wait(FingersScreen(image))
        if picked:
            self.post_message(Wear(*picked))


def _worn(colour: str) -> str:
    return f"at pixel {colour} of the first picture" if "," in colour else colour
