"""Screens that come up over a step: help, and a question before work is lost."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Footer, Static


class HelpScreen(ModalScreen[None]):
    """What this step is for, about the focused widget, and every key that does something now."""

    BINDINGS = [Binding("escape,q,f1,question_mark", "dismiss", "close", id="help.close", tooltip="Close")]

    def __init__(self, about: str, keys: list[tuple[str, str]]) -> None:
        super().__init__()
        self._about, self._keys = about, keys

    def compose(self) -> ComposeResult:
        """Text above, keys below."""
        rows = [Content.assemble((f"{key:>16}", "bold $text-accent"), "  ", what) for key, what in self._keys]
        with VerticalScroll(classes="note"):
            yield Static(self._about, markup=False)
            yield Static("", markup=False)
            yield Static(Content("\n").join(rows), markup=False)
        yield Footer(show_command_palette=False)


class ConfirmScreen(ModalScreen[bool]):
    """A question that defaults to no."""

    BINDINGS = [
        Binding("y", "answer(True)", "yes", id="confirm.yes", tooltip="Do it"),
        Binding("n,escape,enter", "answer(False)", "no", id="confirm.no", tooltip="Leave things as they are"),
    ]

    def __init__(self, question: str) -> None:
        super().__init__()
        self._question = question

    def compose(self) -> ComposeResult:
        """The question and its keys."""
        with Vertical(classes="note"):
            yield Static(self._question, markup=False)
        yield Footer(show_command_palette=False)

    def action_answer(self, yes: bool) -> None:
        """Close with the answer."""
        self.dismiss(yes)
