"""The tables of the steps draw what they hold."""

import pytest
from textual.app import App

from imitate.tui.table import Table


class OneTable(App[None]):
    def compose(self):
        yield Table()


def header(table):
    return "".join(segment.text for segment in table.render_line(0))


@pytest.mark.parametrize("change", ["another row", "another text"])
async def test_a_header_that_was_drawn_too_early_is_drawn_again(change):
    async with OneTable().run_test() as pilot:
        table = pilot.app.query_one(Table)
        table.styles.width, table.styles.height = 60, 10
        for name in ("state", "P"):
            table.add_column(name, key=name)
        table.add_row("{hand}", "20/20", key="0")
        await pilot.pause()
        narrow = header(table).index("P")
        if change == "another row":
            table.add_row("⟨{hand, blue}, green⟩", "0/20")
        else:
            table.update_cell("0", "state", "⟨{hand, blue}, green⟩", update_width=True)
        assert header(table).index("P") == narrow  # drawn before the widths are known
        await pilot.pause()
        assert header(table).index("P") == len(" ⟨{hand, blue}, green⟩  ")
