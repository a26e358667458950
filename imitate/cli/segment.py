"""imitate segment: skills and abstractions of a demonstration, as a table or as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from imitate.cli import console

LEAST = 1e-4
"""probability of a place below which it is left out of the JSON."""

if TYPE_CHECKING:
    from imitate.segmentation import Posterior
    from imitate.segmentation.metrics import Metrics
    from imitate.session.source import Source
    from imitate.settings import Settings
    from imitate.skill import Segment


def segment(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A demonstration or an RGB-D recording.")],
    mode: Annotated[
        str | None,
        typer.Option(
            "--mode",
            metavar="robust|faithful|cst",
            help="The score: robust (default), the paper's, or the baseline CST.",
        ),
    ] = None,
    decisions: Annotated[
        Path | None,
        typer.Option("--decisions", metavar="FILE.json", help="Your decisions, applied to what is found."),
    ] = None,
    truth: Annotated[
        Path | None,
        typer.Option("--truth", metavar="FILE.json", help="The right segmentation, as --json prints one."),
    ] = None,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="SECONDS", min=0, help="How far off a boundary may be.")
    ] = 0.5,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE.png|.svg", help="Draw skills and what speaks for them."),
    ] = None,
    mapping_file: console.MappingFile = None,
    settings_file: console.SettingsFile = None,
    seed: console.Seed = 0,
    as_json: console.Json = False,
    force: console.Force = False,
) -> None:
    """Cut a demonstration into skills.

    For each skill: which objects matter, and in whose reference frame. Exit code 3 says that more than a
    tenth of a recording's frames are missing from it.
    """
    from imitate.formats.decisions import read_decisions
    from imitate.formats.truth import read_truth
    from imitate.segmentation import apply_decisions, changes, doubts, hasty
    from imitate.segmentation import segment as cut
    from imitate.segmentation.metrics import compare
    from imitate.settings import load_settings

    settings = load_settings(settings_file, {"mode": mode} if mode else None)
    decided = read_decisions(decisions) if decisions else ()
    if plot:
        _check_plot(plot, force)
    source = _read(file, settings, seed, mapping_file)
    shown = source.demonstration
    right = read_truth(truth, shown.object_names) if truth else ()
    found = cut(shown, settings.segmentation)
    segments = apply_decisions(found, decided, shown, settings.segmentation)
    for doubt in doubts(shown, found, segments, settings.segmentation) if decided else ():
        console.narrate(str(doubt))
    for carry in hasty(segments, settings.segmentation):
        console.narrate(str(carry))
    sure = changes(shown, segments, settings.segmentation)
    metrics = compare(segments, right, tolerance) if right else None
    if plot:
        from imitate.cli.segment_plot import segment_figure, write_plot

        write_plot(plot, segment_figure(shown, segments, sure, settings.segmentation, file.name), force)
        console.narrate(f"picture: {plot}")
    if as_json:
        console.write_json(_plain(settings.segmentation.mode, segments, sure, metrics))
    else:
        _show(segments, sure)
        if metrics:
            _show_metrics(metrics)
    if source.much_lost:
        raise typer.Exit(console.Exit.LOSSY)


def _read(file: Path, settings: Settings, seed: int, mapping_file: Path | None) -> Source:
    from imitate.formats.mapping import read_mapping
    from imitate.session.source import read_source

    mapping = read_mapping(mapping_file) if mapping_file else None
    with console.progress() as bar:
        task = bar.add_task(f"observing {file.name}", total=None, visible=False)

        def watching(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total, visible=True)

        source = read_source(file, settings, seed, watching, mapping)
    for note in source.notes:
        console.narrate(f"{file}: {note}")
    return source


def _check_plot(plot: Path, force: bool) -> None:
    from imitate.cli.segment_plot import check_plot
    from imitate.formats.output import refuse_existing

    check_plot(plot)
    refuse_existing(plot, force)


def _plain(
    mode: str, segments: Sequence[Segment], sure: Sequence[Posterior], metrics: Metrics | None
) -> dict[str, Any]:
    plain: dict[str, Any] = {
        "mode": mode,
        "segments": [_plain_segment(s) for s in segments],
        "boundaries": [_plain_boundary(s.end, change) for s, change in zip(segments, sure, strict=False)],
    }
    if metrics:
        plain["metrics"] = {
            "tolerance": metrics.tolerance,
            "boundaries": {"found": metrics.found, "true": metrics.true, "matched": metrics.matched},
            "precision": metrics.precision,
            "recall": metrics.recall,
            "worst": metrics.worst,
            "time_share": metrics.time_share,
            "segments": metrics.segments,
            "segments_right": metrics.segments_right,
        }
    return plain


def _plain_segment(s: Segment) -> dict[str, Any]:
    return {
        "start": s.start,
        "end": s.end,
        "relevant": list(s.abstraction.relevant),
        "reference": s.abstraction.reference,
        "alternatives": [
            {
                "relevant": list(c.abstraction.relevant),
                "reference": c.abstraction.reference,
                "log_likelihood": c.log_likelihood,
            }
            for c in s.alternatives
        ],
    }


def _plain_boundary(time: float, change: Posterior) -> dict[str, Any]:
    low, high = change.interval()
    likely = change.probability > LEAST
    return {
        "time": time,
        "low": low,
        "high": high,
        "times": change.times[likely].tolist(),
        "probability": change.probability[likely].tolist(),
    }


def _show(segments: Sequence[Segment], sure: Sequence[Posterior]) -> None:
    columns = ("skill", "from", "to", "change, 90 %", "relevant", "reference", "next best", "nats behind")
    table = console.table(*columns, right=("from", "to", "change, 90 %", "nats behind"))
    for k, s in enumerate(segments):
        runner_up = next((c for c in s.alternatives if c.abstraction != s.abstraction), None)
        low, high = sure[k].interval() if k < len(sure) else (0.0, 0.0)
        table.add_row(
            str(k + 1),
            f"{s.start:.2f} s",
            f"{s.end:.2f} s",
            f"{low:.2f}–{high:.2f} s" if k < len(sure) else "",
            ", ".join(s.abstraction.relevant),
            s.abstraction.reference,
            str(runner_up.abstraction) if runner_up else "",
            f"{s.alternatives[0].log_likelihood - runner_up.log_likelihood:.1f}" if runner_up else "",
        )
    console.show(table)


def _show_metrics(m: Metrics) -> None:
    console.write(
        f"boundaries: {m.matched} of the {m.found} found are right (precision {m.precision:.2f}), "
        f"{m.matched} of the {m.true} right ones were found (recall {m.recall:.2f}), within {m.tolerance:g} s"
        + (f", at most {m.worst:.2f} s off" if m.matched else "")
    )
    console.write(
        f"abstractions: right in {m.time_share:.0%} of the time, and in {m.segments_right} of the "
        f"{m.segments} right skills"
    )
