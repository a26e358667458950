"""The skills as a table, and the ranked alternatives of one of them."""

from __future__ import annotations

from textual.binding import Binding
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from imitate.skill import Segment
from imitate.tui.chosen import Chosen
from imitate.tui.state import Interval
from imitate.tui.table import Table
from imitate.tui.words import change_in_words

COLUMNS = ("#", "start", "end", "relevant", "reference", "by", "change, 90 %")
WIDE = 110
"""columns from which the table says when each change lies; the timeline says it for the selected one."""


class SkillTable(Table):
    """A row for each segment."""

    HELP = (
        "The list of skills: when each starts and ends, which bodies matter, in whose frame they are seen, "
        "and whether that was found (auto) or chosen by you (*)."
    )

    def __init__(self) -> None:
        super().__init__(id="segments", cursor_type="row")

    def show(
        self, segments: tuple[Segment, ...], changes: tuple[Interval, ...], chosen: tuple[Chosen, ...]
    ) -> None:
        """The segments, what the operator chose with a star; the cursor stays where it is."""
        row = min(max(self.cursor_row, 0), max(len(segments) - 1, 0))
        columns = COLUMNS if self.screen.size.width >= WIDE else COLUMNS[:-1]
        fits = len(self.columns) == len(columns)
        self.clear(columns=not fits)
        for name in () if fits else columns:
            self.add_column(name, key=name)
        for i, (s, own) in enumerate(zip(segments, chosen, strict=True)):
            change = change_in_words(changes[i]) if i < len(changes) else ""
            star = "*" if own.abstraction else ""
            about = (
                f"{i + 1}",
                f"{s.start:.2f}{'*' if own.start else ''}",
                f"{s.end:.2f}{'*' if own.end else ''}",
                ", ".join(s.abstraction.relevant) + star,
                s.abstraction.reference + star,
                own.by,
            )
            self.add_row(*(*about, change)[: len(columns)])
        if segments:
            self.move_cursor(row=row, animate=False)


class Alternatives(OptionList):
    """What a skill may be, best first, with how much less it explains than the best."""

    HELP = (
        "The list of what the selected skill may be: ● is what it is, and beside each how much less it "
        "explains of the motion than the best (natural log). Enter chooses, Esc leaves it as it is."
    )
    BINDINGS = [
        Binding(
            "escape", "leave", "skills", id="review.leave", tooltip="Back to the skills; nothing changes"
        ),
    ]

    def __init__(self) -> None:
        super().__init__(id="alternatives", markup=False)
        self._rows: list[str] = []

    def show(self, segment: Segment | None) -> None:
        """Of this segment; nothing without one. Whoever is choosing keeps their place."""
        rows = _rows_of(segment) if segment else []
        if rows == self._rows:
            return
        at, self._rows = self.highlighted if self.has_focus else None, rows
        self.clear_options()
        self.add_options([Option(row, id=str(i)) for i, row in enumerate(rows)])
        if at is not None and rows:
            self.highlighted = min(at, len(rows) - 1)

    def action_leave(self) -> None:
        """Back to the skills."""
        self.highlighted = None
        self.screen.set_focus(self.screen.query_one(SkillTable))


def _rows_of(segment: Segment) -> list[str]:
    best = max((other.log_likelihood for other in segment.alternatives), default=0.0)
    return [
        f"{'●' if other.abstraction == segment.abstraction else '○'} "
        f"{other.log_likelihood - best:6.1f} {other.abstraction}"
        for other in segment.alternatives
    ]
