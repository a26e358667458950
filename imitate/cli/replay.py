"""imitate replay: run a session's trials again and compare every double; or look at the session in Rerun."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.session.replay import Divergence, ReplayReport


def replay(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="A session: sessions/NAME.mcap.")],
    rrd: Annotated[
        Path | None,
        typer.Option("--rrd", metavar="FILE.rrd", help="Also write every step for Rerun's viewer."),
    ] = None,
    robot: console.RobotPlace = "",
    workers: console.Workers = None,
    as_json: console.Json = False,
    force: console.Force = False,
) -> None:
    """Run a session again and compare every bit.

    Exit code 3 says that a step differs or that the file is damaged.
    """
    import os

    from imitate.formats.output import refuse_existing
    from imitate.formats.session_log import summarise
    from imitate.session.replay import replay as run_again

    if rrd:
        refuse_existing(rrd, force)
    total = summarise(session).trials
    with console.progress() as bar:
        task = bar.add_task("replaying", total=total)
        report = run_again(
            session, lambda done, _: bar.update(task, completed=done), workers or os.cpu_count() or 1, robot
        )
    if rrd:
        _write_view(session, rrd, force, total)
    for damage in report.damage:
        console.narrate(f"warning: {session} is damaged: {damage}. What was whole before it was replayed.")
    if as_json:
        console.write_json(_plain(report))
    else:
        _show(report)
    if report.divergent or report.damage:
        raise typer.Exit(console.Exit.LOSSY)


def _write_view(session: Path, rrd: Path, force: bool, total: int) -> None:
    from imitate.events import TrialFinished
    from imitate.formats.session_log import read_session
    from imitate.session.viewer import Viewer

    with console.progress() as bar, Viewer(rrd, force) as viewer:
        task = bar.add_task("writing for Rerun", total=total)
        for event in read_session(session):
            viewer.write(event)
            bar.advance(task, isinstance(event, TrialFinished))
    console.narrate(f"{rrd}: open it with `rerun {rrd}`")


def _plain(report: ReplayReport) -> dict[str, Any]:
    first = report.first_divergence
    return {
        "steps": report.steps,
        "divergent": report.divergent,
        "first_divergence": None
        if first is None
        else {
            "step": first.step,
            "segment": first.segment,
            "trial": first.trial,
            "field": first.field,
            "recorded": _number(first.recorded),
            "replayed": _number(first.replayed),
        },
    }


def _number(value: float) -> float | str:
    """JSON has no NaN and no infinity."""
    return value if math.isfinite(value) else str(value)


def _show(report: ReplayReport) -> None:
    compared = f"{report.steps:,} steps of {report.trials:,} trials"
    if report.first_divergence is None:
        console.write(f"{compared} replayed: every double of every step is the same.")
    else:
        console.write(f"{compared} replayed: {report.divergent:,} steps differ.")
        console.write(_in_words(report.first_divergence))
        for difference in report.machine:
            console.write(f"It was {difference}.")
    if report.unrecorded:
        console.write(f"{report.unrecorded:,} trials were recorded without their steps.")


def _in_words(first: Divergence) -> str:
    return (
        f"First at step {first.step} of trial {first.trial} of segment {first.segment}, formulation "
        f"{first.formulation}: {first.field} was recorded as {first.recorded!r}, replayed as "
        f"{first.replayed!r}."
    )
