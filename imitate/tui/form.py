"""A few values to fill in, over a step; what is wrong with one is said beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Footer, Input, Label, Static


@dataclass(frozen=True)
class Field:
    """One value.

    Attributes:
        name: the key in the result.
        label: what stands beside it.
        value: what stands in it at first.
        about: its unit and meaning.
        fault: what is wrong with a value, in words; empty where nothing is.
    """

    name: str
    label: str
    value: str
    about: str
    fault: Callable[[str], str]


def number(low: float, high: float, whole: bool = False) -> Callable[[str], str]:
    """The fault of what is no number from ``low`` to ``high``."""

    def fault(text: str) -> str:
        try:
            value = int(text) if whole else float(text)
        except ValueError:
            return f"'{text}' is no {'whole ' if whole else ''}number"
        return "" if low <= value <= high else f"{text} is not from {low:g} to {high:g}"

    return fault


class FormScreen(ModalScreen[dict[str, str] | None]):
    """Fields below each other; Enter takes them, Escape leaves everything as it was."""

    BINDINGS = [
        Binding("enter", "take", "take", id="form.take", priority=True, tooltip="Take these values"),
        Binding(
            "down", "app.focus_next", "next", id="form.next", tooltip="The next field; Tab does the same"
        ),
        Binding("up", "app.focus_previous", "before", id="form.before", tooltip="The field before"),
        Binding("escape", "dismiss", "leave", id="form.leave", tooltip="Leave everything as it was"),
    ]

    def __init__(
        self,
        title: str,
        fields: Sequence[Field],
        fault: Callable[[dict[str, str]], str] = lambda _: "",
    ) -> None:
        """``fault``: what is wrong with all values together."""
        super().__init__()
        self._title, self._fields, self._fault = title, fields, fault

    def compose(self) -> ComposeResult:
        """The title, the fields, what is wrong."""
        with Vertical(classes="note form"):
            yield Static(self._title, markup=False, id="title")
            with VerticalScroll(can_focus=False):
                for field in self._fields:
                    with Horizontal():
                        yield Label(field.label, markup=False)
                        yield Input(field.value, id=field.name, compact=True)
                        yield Static(field.about, markup=False, classes="about")
            yield Static("", id="faults", markup=False)
        yield Footer(show_command_palette=False)

    def on_mount(self) -> None:
        """A cursor that stands still where nothing is to move."""
        for field in self.query(Input):
            field.cursor_blink = self.app.animation_level != "none"

    @property
    def values(self) -> dict[str, str]:
        """What stands in the fields."""
        return {field.name: self.query_one(f"#{field.name}", Input).value.strip() for field in self._fields}

    @on(Input.Changed)
    def _on_changed(self) -> None:
        self.query_one("#faults", Static).update(Content("\n").join(
            Content.assemble(("✗ ", "bold $text-error"), fault) for fault in self._faults()
        ))  # fmt: skip

    def _faults(self) -> list[str]:
        values = self.values
        found = [f"{f.label}: {fault}" for f in self._fields if (fault := f.fault(values[f.name]))]
        return found or [fault for fault in (self._fault(values),) if fault]

    def action_take(self) -> None:
        """Close with the values, if nothing is wrong with them."""
        if not self._faults():
            self.dismiss(self.values)
