"""imitate segment: skills and abstractions of a demonstration, as a table or as JSON."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.skill import Segment


def segment(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A demonstration or an RGB-D recording.")],
    mode: Annotated[
        str | None,
        typer.Option("--mode", metavar="robust|faithful", help="The score: robust (default) or the paper's."),
    ] = None,
    decisions: Annotated[
        Path | None,
        typer.Option("--decisions", metavar="FILE.json", help="Your decisions, applied to what is found."),
    ] = None,
    mapping_file: console.MappingFile = None,
    settings_file: console.SettingsFile = None,
    seed: console.Seed = 0,
    as_json: console.Json = False,
) -> None:
    """Cut a demonstration into skills.

    For each skill: which objects matter, and in whose reference frame.
    """
    from imitate.formats.decisions import read_decisions
    from imitate.formats.mapping import read_mapping
    from imitate.segmentation import apply_decisions
    from imitate.segmentation import segment as cut
    from imitate.session.source import read_source
    from imitate.settings import load_settings

    settings = load_settings(settings_file, {"mode": mode} if mode else None)
    decided = read_decisions(decisions) if decisions else ()
    with console.progress() as bar:
        task = bar.add_task(f"observing {file.name}", total=None, visible=False)
        source = read_source(
            file,
            settings,
            seed,
            lambda done, total: bar.update(task, completed=done, total=total, visible=True),
            read_mapping(mapping_file) if mapping_file else None,
        )
    for name, frames in source.lost.items():
        console.narrate(f"{name}: out of sight in {frames} frames; missing there")
    found = cut(source.demonstration, settings.segmentation)
    segments = apply_decisions(found, decided, source.demonstration, settings.segmentation)
    if as_json:
        console.write_json({"mode": settings.segmentation.mode, "segments": [_plain(s) for s in segments]})
    else:
        _show(segments)


def _plain(s: Segment) -> dict[str, Any]:
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


def _show(segments: tuple[Segment, ...]) -> None:
    columns = ("skill", "from", "to", "relevant", "reference", "next best", "nats behind")
    table = console.table(*columns, right=("from", "to", "nats behind"))
    for number, s in enumerate(segments, start=1):
        runner_up = next((c for c in s.alternatives if c.abstraction != s.abstraction), None)
        table.add_row(
            str(number),
            f"{s.start:.2f} s",
            f"{s.end:.2f} s",
            ", ".join(s.abstraction.relevant),
            s.abstraction.reference,
            str(runner_up.abstraction) if runner_up else "",
            f"{s.alternatives[0].log_likelihood - runner_up.log_likelihood:.1f}" if runner_up else "",
        )
    console.show(table)
