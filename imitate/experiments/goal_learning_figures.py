"""Figures of `goal_learning`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from imitate.experiments.drawing import LEGEND, new_figure, style
from imitate.experiments.table import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def errors_figure(rows: Sequence[Row]) -> Figure:
    """Terminal cost and success over how far off the objects were seen."""
    figure, (cost, success) = new_figure(1, 2, 2.6)
    for k, way in enumerate(dict.fromkeys(row["goals"] for row in rows)):
        mine = [row for row in rows if row["goals"] == way]
        judged = [row for row in mine if row["terminal"] is not None]
        cost.errorbar(
            [row["off"] + 0.15 * k for row in judged],
            [row["terminal"] for row in judged],
            [row["terminal_std"] or 0.0 for row in judged],
            **style(k),
            marker="os"[k],
            markersize=4,
            capsize=2,
            label=f"{way} goal learning",
        )
        share = [row["whole"][0] / row["whole"][1] for row in mine]
        success.plot([row["off"] for row in mine], share, **style(k), marker="os"[k], markersize=4)
    cost.set_ylabel("terminal cost of the carry")
    cost.set_ylim(bottom=0)
    success.set_ylabel("share of new starts that succeed")
    success.set_ylim(-0.03, 1.03)
    for panel in (cost, success):
        panel.set_xlabel("objects seen off by (mm)")
    figure.legend(loc="outside lower center", ncols=2, **LEGEND)
    return figure
