"""The list of trials beside the player."""

from __future__ import annotations

from collections.abc import Sequence

from imitate.tui.film import Film
from imitate.tui.table import Table

PURPOSES = {
    "prepare": "prepare",
    "explore": "learn",
    "choose": "choose",
    "evaluate": "judge",
    "reproduce": "whole",
}
"""what a trial was for, as the table says it."""


class FilmTable(Table):
    """A row for each trial; what is new is added below. Follows the newest where it is asked to."""

    HELP = (
        "The list of trials: what each was for, what it cost, and whether every body ended where it was "
        "shown (β). The one under the cursor is shown from above and from the side."
    )

    def __init__(self, columns: tuple[str, ...], follows: bool) -> None:
        super().__init__(id="films", cursor_type="row", zebra_stripes=True)
        self._names = columns
        self.films: Sequence[Film] = ()
        self.following = self._follows = follows

    def on_mount(self) -> None:
        """Its columns."""
        for name in self._names:
            self.add_column(name, key=name)

    @property
    def chosen(self) -> Film | None:
        """The film under the cursor."""
        if not self.row_count:
            return None
        return self.films[min(max(self.cursor_row, 0), self.row_count - 1)]

    def show(self, films: Sequence[Film]) -> None:
        """Add what is new; begin anew with another list."""
        if films is not self.films:
            self.clear()
            self.films, self.following = films, self._follows
        for film in films[self.row_count :]:
            cells = film_cells(film)
            self.add_row(*(cells[name] for name in self._names))

    def action_cursor_up(self) -> None:
        """Whoever chooses a trial looks for themselves."""
        self.following = False
        super().action_cursor_up()

    def action_cursor_down(self) -> None:
        """Likewise."""
        self.following = False
        super().action_cursor_down()

    def on_click(self) -> None:
        """Likewise."""
        self.following = False

    def follow(self) -> None:
        """The cursor to the newest."""
        if self.row_count:
            self.move_cursor(row=self.row_count - 1, animate=False)


def film_cells(film: Film) -> dict[str, str]:
    """What each column says of a trial."""
    return {
        "#": str(film.trial + 1),
        "skill": f"{film.segment + 1}.{film.formulation + 1}" if film.purpose != "reproduce" else "all",
        "for": PURPOSES[film.purpose],
        "cost": f"{film.cost:.1f}",
        "β": "✓" if film.success else "✗",
        "result": "✓ done" if film.success else f"✗ {film.failure}",
    }
