"""Review: the segments, and the operator's say in them."""

from __future__ import annotations

from collections.abc import Iterable

from textual import on
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.widget import Widget
from textual.widgets import DataTable, Footer, Label, OptionList, Static
from textual.widgets.option_list import Option

from imitate.skill import Decision, Segment
from imitate.tui.curve import DistanceCurve
from imitate.tui.intents import Decide, Go, Learn, Nudge, Redo, Split, Undo, Write
from imitate.tui.state import distances
from imitate.tui.step import StepScreen
from imitate.tui.timeline import Timeline
from imitate.tui.words import change_in_words, decision_in_words

COLUMNS = ("#", "start", "end", "relevant", "reference", "by", "change, 90 %")
WIDE = 110
"""columns from which the table says when each change lies; the timeline says it for the selected one."""
NUDGE = 0.1  # s


class ReviewScreen(StepScreen):
    """Timeline, table, ranked alternatives, distances."""

    STEP = "review"
    HELP = (
        "Review: the demonstration was cut into skills. Each has the bodies that matter (relevant) and "
        "the object in whose frame they are seen (reference). Select a skill with up and down. Left and "
        "right move its end (of the last skill: its start) by a frame, with shift by 0.1 s. Enter goes to "
        "the ranked alternatives, with how well each explains the skill (natural log; 0 is the best); "
        "Enter there chooses. Shaded, and beside the mark, is when with 90 % probability the motion "
        "changes from a skill to the next; the rests beside a carry are part of it. x splits the selected "
        "skill where that explains most, m merges it with the next (the last with the one before). Every "
        "change is kept in the session as a decision of yours; w writes them to a file."
    )
    BINDINGS = [
        Binding("left,h", "nudge(-1, 0)", "move", id="review.frame_back", priority=True,
                tooltip="Move the selected boundary by a frame; h and l do the same", key_display="←→"),
        Binding("right,l", "nudge(1, 0)", "frame", id="review.frame_on", priority=True, show=False),
        Binding("shift+left,H", "nudge(0, -1)", "0.1 s", id="review.time_back", priority=True, show=False,
                tooltip="Move it by 0.1 s; shift with the arrows does the same", key_display="HL"),
        Binding("shift+right,L", "nudge(0, 1)", "0.1 s", id="review.time_on", priority=True, show=False),
        Binding("a", "alternatives", "other", id="review.alternatives",
                tooltip="Choose another abstraction for the selected skill"),
        Binding("x", "split", "split", id="review.split",
                tooltip="Split the selected skill in two, where that explains most"),
        Binding("m", "merge", "merge", id="review.merge",
                tooltip="Merge the selected skill with the next one; the last with the one before"),
        Binding("u", "undo", "undo", id="review.undo", tooltip="Take back the last decision"),
        Binding("r,ctrl+y", "redo", "redo", id="review.redo", tooltip="Do again what was undone last"),
        Binding("w", "write", "write", id="review.write", show=False,
                tooltip="Write your decisions to a file in sessions/, for imitate segment and imitate learn"),
        Binding("s", "learn", "learn", id="review.learn", tooltip="Learn these skills"),
    ]  # fmt: skip

    def body(self) -> Iterable[Widget]:
        """Timeline above, table and alternatives in the middle, distances below where there is room."""
        yield Timeline()
        yield Horizontal(
            Vertical(DataTable[str](id="segments", cursor_type="row"), id="cut"),
            Vertical(Label("", id="ranked"), OptionList(id="alternatives", markup=False), id="others"),
            id="middle",
        )
        yield DistanceCurve()
        yield Static("", id="decided", markup=False)

    def on_mount(self) -> None:
        """The first picture."""
        self.query_one(Footer).compact = True  # all keys fit into 80 columns
        super().on_mount()
        self.query_one("#segments", DataTable).focus()

    def on_resize(self) -> None:
        """Columns that fit."""
        self.redraw()

    @property
    def selected(self) -> int:
        """Index of the selected segment."""
        row = self.query_one("#segments", DataTable).cursor_row
        return min(max(row, 0), max(len(self.state.segments) - 1, 0))

    @property
    def boundary(self) -> int:
        """The boundary that keys move: the selected segment's end, the last one's start."""
        return min(self.selected, len(self.state.segments) - 2)

    def draw(self) -> None:
        """Everything."""
        super().draw()
        self._draw_table()
        self._draw_selection()
        self.query_one("#decided", Static).update(f" {self._standing()}")

    def _standing(self) -> str:
        state, text = self.state, "as found; nothing decided yet"
        if state.decisions:
            last = decision_in_words(state.decisions[-1])
            text = f"{state.undoable} decisions of yours (w writes them), the last: {last}"
        if state.running:
            return f"{text}  (learning runs)"
        return text if state.editable else f"{text}  (recorded: open its demonstration to decide)"

    def _draw_table(self) -> None:
        table = self.query_one("#segments", DataTable)
        row = self.selected
        columns = COLUMNS if self.size.width >= WIDE else COLUMNS[:-1]
        fits = len(table.columns) == len(columns)
        table.clear(columns=not fits)
        for name in () if fits else columns:
            table.add_column(name, key=name)
        for i, s in enumerate(self.state.segments):
            relevant = ", ".join(s.abstraction.relevant)
            by = "you" if s.human else "auto"
            change = change_in_words(self.state.changes[i]) if i < len(self.state.changes) else ""
            about = (f"{i + 1}", f"{s.start:.2f}", f"{s.end:.2f}", relevant, s.abstraction.reference, by)
            table.add_row(*(*about, change)[: len(columns)])
        if self.state.segments:
            table.move_cursor(row=row, animate=False)

    def _draw_selection(self) -> None:
        segments = self.state.segments
        self.query_one(Timeline).show(segments, self.selected, self.boundary, self.state.changes)
        self._draw_alternatives(segments[self.selected] if segments else None)
        if self.state.demonstration:
            cuts = [s.end for s in segments[:-1]]
            self.query_one(DistanceCurve).show(distances(self.state.demonstration), cuts, self.boundary)

    def _draw_alternatives(self, segment: Segment | None) -> None:
        self.query_one("#ranked", Label).update(f"skill {self.selected + 1} may be")
        options = self.query_one("#alternatives", OptionList)
        options.clear_options()
        if not segment or not segment.alternatives:
            return
        best = segment.alternatives[0].log_likelihood
        for i, other in enumerate(segment.alternatives):
            sign = "●" if other.abstraction == segment.abstraction else "○"
            gap = other.log_likelihood - best
            options.add_option(Option(f"{sign} {gap:6.1f} {other.abstraction}", id=str(i)))

    @on(DataTable.RowHighlighted, "#segments")
    def _on_row(self) -> None:
        self._draw_selection()

    @on(DataTable.RowSelected, "#segments")
    def action_alternatives(self) -> None:
        """To the ranked alternatives of the selected skill."""
        options = self.query_one("#alternatives", OptionList)
        if options.option_count:
            options.focus()
            options.highlighted = 0

    @on(OptionList.OptionSelected, "#alternatives")
    def _on_alternative(self, event: OptionList.OptionSelected) -> None:
        chosen = self.state.segments[self.selected].alternatives[event.option_index].abstraction
        self.query_one("#segments", DataTable).focus()
        self.post_message(Decide(Decision("relabel", self.selected, abstraction=chosen)))

    def action_nudge(self, frames: int, tenths: int) -> None:
        """Move the selected boundary."""
        self.post_message(Nudge(self.boundary, frames, tenths * NUDGE))

    def action_split(self) -> None:
        """Split the selected segment."""
        self.post_message(Split(self.selected))

    def action_merge(self) -> None:
        """Merge the segments on either side of the selected boundary."""
        self.post_message(Decide(Decision("merge", self.boundary)))

    def action_undo(self) -> None:
        """Take back the last decision."""
        self.post_message(Undo())

    def action_redo(self) -> None:
        """Do again what was undone last."""
        self.post_message(Redo())

    def action_write(self) -> None:
        """Write the decisions to a file."""
        self.post_message(Write())

    def action_learn(self) -> None:
        """Learn these skills; while they are learned, look."""
        self.post_message(Go("learn") if self.state.running else Learn())

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Keys that would change a session which cannot be changed are greyed."""
        changes = action in ("nudge", "alternatives", "split", "merge", "undo", "redo")
        if action == "learn" and self.state.kind == "session":
            return False
        if action == "merge" and len(self.state.segments) < 2:
            return False
        if action == "redo" and not self.state.redoable:
            return False
        if action == "write" and not self.state.decisions:
            return False
        return None if changes and not self.state.editable else super().check_action(action, parameters)
