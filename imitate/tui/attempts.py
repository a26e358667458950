"""The table of formulations: one row each, by skill."""

from __future__ import annotations

from textual.widgets import DataTable

from imitate.tui.state import State
from imitate.tui.words import outcome

COLUMNS = ("skill", "state", "actions", "trials", "cost", "P", "outcome")


class AttemptTable(DataTable[str]):
    """Follows the present formulation until the cursor is moved away from it."""

    def __init__(self) -> None:
        super().__init__(cursor_type="row", zebra_stripes=True)
        self._rows: list[tuple[str, ...]] = []
        self.following = True

    def on_mount(self) -> None:
        """Its columns."""
        for name in COLUMNS:
            self.add_column(name, key=name)

    def show(self, state: State) -> None:
        """Change the cells that differ, add the rows that are new."""
        rows = attempt_rows(state)
        if rows[: len(self._rows)] != self._rows and len(rows) < len(self._rows):
            self.clear()
            self._rows = []
        for i, row in enumerate(rows):
            if i >= len(self._rows):
                self.add_row(*row, key=str(i))
            else:
                self._change(i, self._rows[i], row)
        self._rows = rows
        if self.following and rows:
            self.move_cursor(row=len(rows) - 1, animate=False)

    def _change(self, i: int, old: tuple[str, ...], new: tuple[str, ...]) -> None:
        for column, before, after in zip(COLUMNS, old, new, strict=True):
            if before != after:
                self.update_cell(str(i), column, after, update_width=True)


def attempt_rows(state: State) -> list[tuple[str, ...]]:
    """Cells of every formulation so far."""
    rows: list[tuple[str, ...]] = []
    for attempt in state.attempts:
        stated, judged = attempt.formulation, attempt.evaluated
        present = attempt is state.progress.present
        rows.append(
            (
                str(stated.segment + 1),
                str(stated.abstraction),
                "+".join(stated.actions),
                str(attempt.explored),
                "" if attempt.cost is None else f"{attempt.cost:.1f}",
                f"{judged.successes}/{judged.trials}" if judged else "",
                outcome(attempt, present, state.running),
            )
        )
    return rows
