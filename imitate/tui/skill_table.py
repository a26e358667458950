"""The skills as a table, and the ranked alternatives of one of them."""

from __future__ import annotations

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

    def __init__(self) -> None:
        super().__init__(id="alternatives", markup=False)

    def show(self, segment: Segment | None) -> None:
        """Of this segment; nothing without one."""
        self.clear_options()
        if not segment or not segment.alternatives:
            return
        best = segment.alternatives[0].log_likelihood
        for i, other in enumerate(segment.alternatives):
            sign = "●" if other.abstraction == segment.abstraction else "○"
            gap = other.log_likelihood - best
            self.add_option(Option(f"{sign} {gap:6.1f} {other.abstraction}", id=str(i)))
