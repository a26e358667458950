"""The steps of a session at the top of the screen."""

from __future__ import annotations

from textual.content import Content
from textual.widgets import Static

from imitate.tui.state import State, Step
from imitate.tui.words import short


class Road(Static):
    """✓ what is done, ● where we are, ○ what is to come; and the file."""

    def __init__(self, state: State, here: Step) -> None:
        super().__init__(markup=False)
        self._state, self._here = state, here

    def draw(self) -> None:
        """Show the state as it is now."""
        parts: list[Content] = [Content.styled(" imitate ", "bold $text on $primary-muted"), Content("  ")]
        steps = self._state.steps
        position = steps.index(self._here) if self._here in steps else 0
        for i, step in enumerate(steps):
            sign, style = self._look(step, i, position)
            parts.append(Content.styled(f"{sign} {step.capitalize()}", style))
            parts.append(Content(" ─ " if i < len(steps) - 1 else ""))
        if self._state.source:
            parts.append(Content.styled(f"  {short(self._state.source)}", "$text-muted"))
        self.update(Content("").join(parts))

    def _look(self, step: Step, i: int, position: int) -> tuple[str, str]:
        if i == position:
            return "●", "bold $text-primary"
        if i < position or self._state.reachable(step) or self._state.passed(step):
            return "✓", "$text-success"
        return "○", "$text-muted"
