"""A widget that is drawn in braille dots."""

from __future__ import annotations

from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

from imitate.tui.dots import Dots


class Drawing(Widget):
    """Draws itself anew at each size, and whenever it is asked to."""

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self.dots = Dots(1, 1)

    def on_resize(self) -> None:
        """Draw anew at the new size."""
        self.redraw()

    def redraw(self) -> None:
        """Draw anew."""
        if self.size.area:
            self.dots = Dots(*self.size)
            self.draw()
            self.refresh()

    def draw(self) -> None:
        """Draw on ``dots``, which are empty."""
        raise NotImplementedError

    def ink(self, name: str) -> Style:
        """A colour of the theme, by name."""
        colour = self.app.theme_variables.get(name, "")
        return Style.parse(colour[:7]) if colour.startswith("#") else Style.null()

    def render_line(self, y: int) -> Strip:
        """Row ``y`` of what was drawn last."""
        if self.dots.rows != self.size.height:
            return Strip.blank(self.size.width, self.rich_style)
        return self.dots.strip(y).apply_style(self.rich_style)
