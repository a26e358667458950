"""Done: what came of it, where it is, and what to do next."""

from __future__ import annotations

from collections.abc import Iterable

from textual.binding import Binding
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from imitate.tui.attempts import AttemptTable
from imitate.tui.intents import Go
from imitate.tui.state import State
from imitate.tui.step import StepScreen
from imitate.tui.words import short, verdict


class DoneScreen(StepScreen):
    """The verdict, the table, the file and the commands that go on from it."""

    STEP = "done"
    HELP = (
        "Done: the result of the session. The file holds every physics step; imitate replay simulates it "
        "again and compares every bit. Esc goes back to the curves, and from there to the segments."
    )
    BINDINGS = [Binding("n", "new", "another file", id="done.new", tooltip="Open another file")]

    def body(self) -> Iterable[Widget]:
        """Verdict, table, what next."""
        yield Static("", id="verdict", markup=False)
        yield AttemptTable()
        yield Static("", id="next", markup=False)

    def on_mount(self) -> None:
        """The table has the focus, so that it scrolls."""
        super().on_mount()
        table = self.query_one(AttemptTable)
        table.following = False
        table.focus()

    def draw(self) -> None:
        """Everything."""
        super().draw()
        progress = self.state.progress
        good = bool(progress.finished and progress.finished.reproduced)
        words = verdict(progress, progress.settings.learning.alpha)
        self.query_one("#verdict", Static).update(
            Content.styled(words, "bold $text-success" if good else "bold $text-warning")
        )
        self.query_one(AttemptTable).show(self.state)
        self.query_one("#next", Static).update(next_words(self.state))

    def action_new(self) -> None:
        """Back to the files."""
        self.post_message(Go("load"))


def next_words(state: State) -> Content:
    """Advice, the file, and the commands that take it."""
    lines = []
    finished = state.progress.finished
    if finished and finished.advice:
        lines += [Content(finished.advice), Content("")]
    if state.log:
        lines.append(Content.assemble(("session  ", "$text-muted"), short(state.log)))
        lines.append(Content.assemble(("replay   ", "$text-muted"), f"imitate replay {short(state.log)}"))
        if finished:
            lines.append(
                Content.assemble(("run more ", "$text-muted"), f"imitate reproduce {short(state.log)}")
            )
    return Content("\n").join(lines)
