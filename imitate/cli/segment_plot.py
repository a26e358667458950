"""A picture of a segmentation and of what speaks for it, as PNG or SVG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from imitate.demonstration import HAND, Demonstration
from imitate.errors import FileError
from imitate.experiments.drawing import STYLE, WIDTH, style
from imitate.formats.output import new_file
from imitate.segmentation.posteriors import Posterior
from imitate.segmentation.robust import RobustScore
from imitate.settings import Segmentation
from imitate.skill import Segment

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg")


def check_plot(path: Path) -> None:
    """Raises FileError unless the name of a picture ends in .png or .svg."""
    if path.suffix.lower() not in FORMATS:
        raise FileError(
            path, f"cannot be drawn: unknown suffix {path.suffix!r}", f"Use {' or '.join(FORMATS)}."
        )


def write_plot(path: Path, figure: Figure, force: bool = False) -> None:
    """Writes a figure by its suffix; equal figures are equal files.

    Raises:
        FileError: the file exists and ``force`` is not given, or it cannot be written.
    """
    import matplotlib

    form = path.suffix.lower()[1:]
    with new_file(path, force) as temporary, matplotlib.rc_context({"svg.hashsalt": "imitate"}):
        figure.savefig(temporary, format=form, dpi=150, metadata={"Date": None} if form == "svg" else None)


def segment_figure(
    demonstration: Demonstration,
    segments: Sequence[Segment],
    changes: Sequence[Posterior],
    settings: Segmentation,
    title: str,
) -> Figure:
    """Bands of skills; below them, over time, distance, co-motion, and where each change lies.

    A last row shows when a body was not seen, if there was one.

    Args:
        changes: of each boundary between ``segments``, as `imitate.segmentation.posteriors` finds them.
        settings: whose robust score gives the co-motion, also where the mode is another.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    d = demonstration
    unseen = {name: ~d.seen(name) for name in (HAND, *d.object_names) if not d.seen(name).all()}
    heights = [0.9, 2.2, 1.8, 1.3, *([0.25 + 0.16 * len(unseen)] if unseen else [])]
    with matplotlib.rc_context({**STYLE, "text.parse_math": False}):  # "$" stands in names, and so does "_"
        figure = Figure(figsize=(WIDTH, 1.05 * sum(heights) + 0.5), layout="constrained")
        rows: list[Axes] = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
        figure.suptitle(title, fontsize=9)
        _distances(rows[1], d)
        _co_motion(rows[2], d, settings)
        _changes(rows[3], changes)
        if unseen:
            _unseen(rows[4], d, unseen)
        rows[-1].set_xlabel("time (s)")
        rows[0].set_xlim(segments[0].start, segments[-1].end)
        for row in rows[1:]:
            _boundaries(row, segments)
        handles, labels = rows[1].get_legend_handles_labels()
        numbered = _bands(figure, rows[0], segments)
        handles += [Line2D([], [], linestyle="none") for _ in numbered]
        columns = 5 if not numbered else 3
        figure.set_figheight(figure.get_figheight() + 0.17 * -(-len(handles) // columns))
        figure.legend(handles, [*labels, *numbered], loc="outside lower center", ncols=columns, frameon=False)
    return figure


def _distances(row: Axes, d: Demonstration) -> None:
    t = d.t - d.t[0]
    for k, name in enumerate(d.object_names):
        apart = np.linalg.norm(d.pose_of(name)[:, :3] - d.hand[:, :3], axis=1)
        row.plot(t, apart, label=f" {name}" if name.startswith("_") else name, **style(k))
    if d.opening is not None:
        row.plot(t, d.opening, label="opening of the hand", color="0.2", linewidth=0.8)
    row.set_ylim(bottom=0)
    row.set_ylabel("hand to object (m)")


def _co_motion(row: Axes, d: Demonstration, settings: Segmentation) -> None:
    score = RobustScore(d, settings)
    for k, said in enumerate(score.said.T):
        row.plot(score.times, said, **style(k))
    row.axhline(0, color="0.4", linewidth=0.6)
    row.set_ylabel("co-motion\n(nats a frame)")


def _changes(row: Axes, changes: Sequence[Posterior]) -> None:
    for change in changes:
        step = float(np.median(np.diff(change.times))) if len(change.times) > 1 else 1.0
        density = change.probability / step
        row.fill_between(change.times, density, step="mid", color="0.55", linewidth=0)
        row.step(change.times, density, where="mid", color="0.1", linewidth=0.8)
    row.set_ylim(bottom=0)
    row.set_ylabel("change here\n(probability / s)")


def _unseen(row: Axes, d: Demonstration, unseen: dict[str, Any]) -> None:
    t = d.t - d.t[0]
    edges = np.concatenate([t[:1], (t[1:] + t[:-1]) / 2, t[-1:]])
    for k, missing in enumerate(unseen.values()):
        turns = np.flatnonzero(np.diff(np.concatenate([[0], missing.astype(int), [0]])))
        spans = [(edges[a], edges[b] - edges[a]) for a, b in turns.reshape(-1, 2)]
        row.broken_barh(
            spans, (k - 0.35, 0.7), facecolor="0.75", edgecolor="0.2", hatch="////", linewidth=0.4
        )
    row.set_yticks(range(len(unseen)), list(unseen))
    row.set_ylim(len(unseen) - 0.5, -0.5)
    row.set_ylabel("not seen")


def _boundaries(row: Axes, segments: Sequence[Segment]) -> None:
    for k, s in enumerate(segments):
        if k % 2:
            row.axvspan(s.start, s.end, color="0.94", zorder=0, linewidth=0)
        if k:
            row.axvline(s.start, color="0.2", linewidth=0.7, linestyle=(0, (2, 2)))


def _bands(figure: Figure, row: Axes, segments: Sequence[Segment]) -> list[str]:
    """Each skill's number and abstraction; across where it fits, else the number alone.

    Returns:
        The words of those that have the number alone.
    """
    numbered = []
    row.set_yticks([])
    row.spines["left"].set_visible(False)
    row.set_ylim(0, 1)
    for k, s in enumerate(segments):
        carried = bool(s.abstraction.carried)
        row.axvspan(s.start, s.end, facecolor="0.8" if carried else "0.94", edgecolor="0.2", linewidth=0.7)
        row.text((s.start + s.end) / 2, 0.5, str(k + 1), ha="center", va="center")
    row.set_ylabel("skill")
    figure.draw_without_rendering()  # lays out, so that text can be measured
    for k, (s, text) in enumerate(zip(segments, list(row.texts), strict=True)):
        left, right = row.transData.transform([(s.start, 0), (s.end, 0)])[:, 0]
        for words in _wordings(k + 1, s):
            text.set_text(words)
            if text.get_window_extent().width <= 0.95 * (right - left):
                break
        if text.get_text() == str(k + 1):
            numbered.append(f"{k + 1}  {s.abstraction}")
    return numbered


def _wordings(number: int, s: Segment) -> list[str]:
    relevant, reference = ", ".join(s.abstraction.relevant), s.abstraction.reference
    across, broken = f"⟨{{{relevant}}}, {reference}⟩", f"⟨{{{relevant}}},\n{reference}⟩"
    return [f"{number}  {across}", f"{number}\n{across}", f"{number}\n{broken}", str(number)]
