"""The tree of formulations: by skill, those tried, the present one, and those that come next."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

from imitate.learning.statements import Statement, statements
from imitate.session.progress import Attempt, Skill
from imitate.tui.state import State
from imitate.tui.table import Table
from imitate.tui.words import outcome

COLUMNS = ("skill", "state", "actions", "trials", "cost", "P", "outcome")
AHEAD = 2
"""formulations that are named before they are tried, of the present skill."""


@dataclass(frozen=True)
class Branch:
    """A formulation: one that was tried or is, or one that may come.

    Attributes:
        skill: its number, from 0.
        attempt: None of one that may come.
        statement: what it states.
        when: of one that may come, when it would.
    """

    skill: int
    attempt: Attempt | None
    statement: Statement
    when: str = ""


class AttemptTable(Table):
    """Follows the present formulation until the cursor is moved away from it."""

    HELP = (
        "The tree of formulations: below each skill those that were tried, the present one, and those that "
        "come if it fails; with the trials spent, the best cost, and P, the share of disturbed starts that "
        "succeeded."
    )

    def __init__(self) -> None:
        super().__init__(cursor_type="row", zebra_stripes=True)
        self._rows: list[tuple[str, ...]] = []
        self.branches: list[Branch] = []
        self.present = 0  # the row of the formulation that was begun last
        self.following = True

    def on_mount(self) -> None:
        """Its columns."""
        for name in COLUMNS:
            self.add_column(name, key=name)

    @property
    def chosen(self) -> Branch | None:
        """The formulation under the cursor."""
        if not self.branches:
            return None
        return self.branches[min(max(self.cursor_row, 0), len(self.branches) - 1)]

    def action_cursor_up(self) -> None:
        """Whoever chooses a formulation looks for themselves, until it is the present one."""
        super().action_cursor_up()
        self.following = self.cursor_row == self.present

    def action_cursor_down(self) -> None:
        """Likewise."""
        super().action_cursor_down()
        self.following = self.cursor_row == self.present

    def on_click(self) -> None:
        """Likewise."""
        self.following = False

    def show(self, state: State) -> None:
        """Change the cells that differ, add the rows that are new, take away those that do not come."""
        self.branches, present = branches(state), state.progress.present
        rows_of_present = [k for k, b in enumerate(self.branches) if b.attempt and b.attempt is present]
        self.present = next(iter(rows_of_present), 0)
        rows = [_cells(branch, sign, state) for branch, sign in _drawn(self.branches)]
        for i in range(len(rows), len(self._rows)):
            self.remove_row(str(i))
        for i, row in enumerate(rows):
            if i >= len(self._rows):
                self.add_row(*row, key=str(i))
            else:
                self._change(i, self._rows[i], row)
        self._rows = rows
        if self.following and rows:
            self.move_cursor(row=self.present, animate=False)
            self.call_after_refresh(self._lead)

    def on_resize(self) -> None:
        """The present formulation stays in view."""
        if self.following:
            self.call_after_refresh(self._lead)

    def _lead(self) -> None:
        # Wherever it stood before, as much is seen of what comes next as there is room for.
        room = self.scrollable_content_region.height - self.header_height
        self.scroll_to(y=max(0, min(self.present, self.present + 1 + AHEAD - room)), animate=False)

    def _change(self, i: int, old: tuple[str, ...], new: tuple[str, ...]) -> None:
        for column, before, after in zip(COLUMNS, old, new, strict=True):
            if before != after:
                self.update_cell(str(i), column, after, update_width=True)


def branches(state: State) -> list[Branch]:
    """Every formulation so far; those that may come, too, while learning or where it can be gone on with."""
    going = state.running or state.resumable
    found: list[Branch] = []
    for skill in state.progress.skills:
        found += [
            Branch(skill.index, a, (a.formulation.abstraction, a.formulation.actions)) for a in skill.attempts
        ]
        if going and not skill.accepted:
            found += _to_come(state, skill)
    return found


def _to_come(state: State, skill: Skill) -> list[Branch]:
    learning = state.progress.settings.learning
    order = statements(skill.segment, learning)
    present = state.progress.present
    here = present is not None and present.formulation.segment == skill.index
    if not here or present is None:
        return [Branch(skill.index, None, order[0], "to come")]
    stated = (present.formulation.abstraction, present.formulation.actions)
    after = order[order.index(stated) + 1 :] if stated in order and learning.reformulate else []
    when = ("next", "then")
    return [Branch(skill.index, None, s, w) for s, w in zip(after[:AHEAD], when, strict=False)]


def _drawn(all_branches: list[Branch]) -> list[tuple[Branch, str]]:
    # Each with its skill's number and its place among that skill's.
    drawn = []
    for skill, group in groupby(all_branches, key=lambda branch: branch.skill):
        row = list(group)
        for k, branch in enumerate(row):
            first, last = k == 0, k == len(row) - 1
            sign = (" " if last else "┬") if first else "└" if last else "├"
            drawn.append((branch, f"{skill + 1 if first else ' '} {sign}".rstrip()))
    return drawn


def _cells(branch: Branch, place: str, state: State) -> tuple[str, ...]:
    abstraction, actions = branch.statement
    attempt = branch.attempt
    what = (place, str(abstraction), "+".join(actions))
    if attempt is None:
        return (*what, "", "", "", f"○ {branch.when}")
    judged, present = attempt.evaluated, attempt is state.progress.present
    return (
        *what,
        str(attempt.explored),
        "" if attempt.cost is None else f"{attempt.cost:.1f}",
        f"{judged.successes}/{judged.trials}" if judged else "",
        outcome(attempt, present, state.running),
    )
