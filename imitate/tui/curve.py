"""Curves: the cost of trials and updates, and the force of the gripper."""

from __future__ import annotations

import numpy as np
from textual.app import ComposeResult
from textual.containers import Grid
from textual.strip import Strip
from textual_hires_canvas import Canvas
from textual_plot import HiResMode, PlotWidget
from textual_plot.plot_widget import Legend

from imitate.geometry import Array
from imitate.tui.costs import Curve, Terms

SIGNS: dict[Terms, tuple[str, str]] = {
    "end": ("e", "text-accent"),
    "acceleration": ("a", "text-secondary"),
    "gripper": ("g", "text-warning"),
}
"""the letter of each part of the cost, and a colour."""


class _Canvas(Canvas):
    """A canvas that NO_COLOR can be applied to, which fails on the original's unstyled empty lines."""

    def render_line(self, y: int) -> Strip:
        """A line, none where the canvas has not been drawn on yet."""
        strip = super().render_line(y)
        return strip if strip.cell_length else Strip([])


class Plot(PlotWidget):
    """A plot that is only looked at."""

    can_focus = False

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id, allow_pan_and_zoom=False)

    def compose(self) -> ComposeResult:
        """As the original, with the canvas above."""
        with Grid():
            for part in ("margin-top", "margin-left", "plot", "margin-bottom"):
                yield _Canvas(1, 1, id=part)
        yield Legend(id="legend")

    def on_mount(self) -> None:
        """No line is wasted below the axis."""
        super().on_mount()
        self.margin_bottom = 2


class CostCurve(Plot):
    """○ a trial that failed, ● one in which β held, ◆ the policy after an update, ╌ C; ↑ is off the scale.

    Where they are asked for: e, a and g, what each trial's end, its acceleration and its gripper cost.
    """

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[Curve, float | None] | None = None

    def show(self, curve: Curve, threshold: float | None) -> None:
        """Draw anew where something changed."""
        if self._shown == (curve, threshold):
            return
        self._shown = (curve, threshold)
        colours = self.app.theme_variables
        with self.app.batch_update():
            self.clear()
            top = self._scale(curve, threshold)
            self.set_ylabel("cost, by trial")
            if curve.updates:
                line = plain(colours, "text-primary")
                self.plot(*_columns(curve.updates), line_style=line, hires_mode=HiResMode.BRAILLE)
            for points, sign, colour in (
                (curve.failed, "○", "foreground"),
                (curve.succeeded, "●", "text-success"),
                (curve.updates, "◆", "text-primary"),
            ):
                self._points(points, sign, plain(colours, colour), top)
            for term, points in curve.terms:
                sign, colour = SIGNS[term]
                self._points(points, sign, plain(colours, colour), top)
            if threshold is not None:
                x = np.linspace(*self._span(curve), 60)
                self.scatter(
                    x, np.full_like(x, threshold), marker="╌", marker_style=plain(colours, "warning")
                )

    def _span(self, curve: Curve) -> tuple[float, float]:
        parts = [point for _, points in curve.terms for point in points]
        numbers = [number for number, _ in (*curve.failed, *curve.succeeded, *parts)]
        return 0.0, float(max([10, *numbers]) + 1)

    def _points(self, points: tuple[tuple[int, float], ...], sign: str, style: str, top: float) -> None:
        # A trial that was stopped costs ten times as much as others: it must not flatten them.
        inside = tuple((x, y) for x, y in points if y <= top)
        above = tuple((x, 0.98 * top) for x, y in points if y > top)
        for some, marker in ((inside, sign), (above, "↑")):
            if some:
                self.scatter(*_columns(some), marker=marker, marker_style=style)

    def _scale(self, curve: Curve, threshold: float | None) -> float:
        parts = [point for _, points in curve.terms for point in points]
        costs = [cost for _, cost in (*curve.failed, *curve.succeeded, *curve.updates, *parts)]
        usual = [cost for cost in costs if cost <= 4 * float(np.median(costs))]
        top = 1.08 * max([1.0, *usual, *([threshold] if threshold is not None else [])])
        self.set_xlimits(*self._span(curve))
        self.set_ylimits(0.0, top)
        return top


class ForceCurve(Plot):
    """The gripper's force along a skill, newtons by second; 0 is open."""

    def show(self, profile: tuple[Array, Array] | None) -> None:
        """Draw (T,) seconds and (T,) newtons; nothing without them."""
        with self.app.batch_update():
            self.clear()
            if profile is None:
                return
            t, force = profile
            line = plain(self.app.theme_variables, "text-warning")
            self.plot(t, force, line_style=line, hires_mode=HiResMode.BRAILLE)
            self.set_xlimits(0.0, float(t[-1]))
            self.set_ylimits(0.0, 1.1 * max(1.0, float(force.max())))
            self.set_ylabel("force, N")


def _columns(points: tuple[tuple[int, float], ...]) -> tuple[Array, Array]:
    x, y = np.asarray(points, float).T
    return x, y


def plain(colours: dict[str, str], name: str) -> str:
    """A theme's colour as the canvas wants it: hexadecimal, without transparency."""
    value = colours.get(name, "")
    return value[:7] if value.startswith("#") else "default"
