"""The tables of the steps."""

from __future__ import annotations

from collections.abc import Iterable

from rich.text import Text
from textual.widgets import DataTable
from textual.widgets.data_table import ColumnKey, RowKey


class Table(DataTable[Text]):
    """A table of plain text, drawn anew when its columns have become wider.

    Textual takes a string for markup, in which the name "cube[left]" is "cube". And it keeps a line as long
    as no cell changes: drawn between a change and the new widths it would stay.
    """

    def add_row(
        self,
        *cells: str | Text,
        height: int | None = 1,
        key: str | None = None,
        label: str | Text | None = None,
    ) -> RowKey:
        """As Textual's, of plain text."""
        return super().add_row(*map(_plain, cells), height=height, key=key, label=label)

    def update_cell(
        self,
        row_key: RowKey | str,
        column_key: ColumnKey | str,
        value: str | Text,
        *,
        update_width: bool = False,
    ) -> None:
        """As Textual's, of plain text."""
        super().update_cell(row_key, column_key, _plain(value), update_width=update_width)

    def _update_dimensions(self, new_rows: Iterable[RowKey]) -> None:
        super()._update_dimensions(new_rows)
        self._update_count += 1
        self.refresh()


def _plain(cell: str | Text) -> Text:
    return Text(cell, no_wrap=True, end="") if isinstance(cell, str) else cell
