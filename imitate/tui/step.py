"""What every step's screen has: the road above, keys below, and how to get from step to step."""

from __future__ import annotations

from collections.abc import Iterable

from textual.app import ComposeResult
from textual.binding import Binding
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Footer

from imitate.tui.intents import Go
from imitate.tui.road import Road
from imitate.tui.state import State, Step


class StepScreen(Screen[None]):
    """One step; renders the state in `draw` and posts intents."""

    STEP: Step
    HELP = ""
    BINDINGS = [
        Binding("escape", "back", "back", id="step.back", tooltip="One step back; everything done is kept"),
        Binding("n", "on", "on", id="step.on", tooltip="One step on"),
        Binding("j", "cursor('down')", "down", id="step.down", show=False),
        Binding("k", "cursor('up')", "up", id="step.up", show=False),
    ]

    def __init__(self, state: State) -> None:
        super().__init__()
        self.state = state
        self._keys: tuple[tuple[str, str, bool], ...] = ()

    def compose(self) -> ComposeResult:
        """The road, the step's own widgets, the keys."""
        yield Road(self.state, self.STEP)
        yield from self.body()
        yield Footer(show_command_palette=False)

    def body(self) -> Iterable[Widget]:
        """The step's own widgets."""
        raise NotImplementedError

    def draw(self) -> None:
        """Show the state as it is now; called at most ten times a second."""
        self.query_one(Road).draw()

    def on_mount(self) -> None:
        """First picture."""
        self.draw()

    def on_screen_resume(self) -> None:
        """The state may have changed while another step was shown."""
        self.redraw()

    def redraw(self) -> None:
        """Draw anew, once there are widgets to draw on."""
        if self.is_mounted and self.is_attached:
            self.draw()
            self._draw_keys()

    def _draw_keys(self) -> None:
        # Textual's footer is made anew each time, and what it was made of before is never freed.
        active = self.active_bindings.values()
        keys = tuple((key.binding.key, key.binding.action, key.enabled) for key in active)
        if keys != self._keys:
            self._keys = keys
            self.refresh_bindings()

    def action_back(self) -> None:
        """To the last step before this one that has something to show."""
        self._walk(-1)

    def action_on(self) -> None:
        """To the next step after this one that has something to show."""
        self._walk(1)

    def action_cursor(self, direction: str) -> None:
        """Letters beside the arrow keys, in whatever list has the focus."""
        move = getattr(self.focused, f"action_cursor_{direction}", None)
        if move:
            move()

    def _walk(self, direction: int) -> None:
        step = self._beside(direction)
        if step:
            self.post_message(Go(step))

    def _beside(self, direction: int) -> Step | None:
        steps = self.state.steps
        i = steps.index(self.STEP) + direction if self.STEP in steps else -1
        while 0 <= i < len(steps):
            if self.state.reachable(steps[i]):
                return steps[i]
            i += direction
        return None

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Back and on are there where they lead somewhere; None greys a key, False hides it."""
        if action in ("back", "on"):
            return self._beside(1 if action == "on" else -1) is not None
        return True
