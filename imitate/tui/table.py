"""The tables of the steps."""

from __future__ import annotations

from collections.abc import Iterable

from textual.widgets import DataTable
from textual.widgets.data_table import RowKey


class Table(DataTable[str]):
    """A table that is drawn anew when its columns have become wider.

    Textual keeps a line as long as no cell changes: drawn between a change and the new widths it would stay.
    """

    def _update_dimensions(self, new_rows: Iterable[RowKey]) -> None:
        super()._update_dimensions(new_rows)
        self._update_count += 1
        self.refresh()
