"""imitate replay: run a session again, at one of three depths, and compare every double."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from imitate.cli import console, replayed

if TYPE_CHECKING:
    from imitate.session.replay import Part, ReplayReport
    from imitate.session.rerun import RerunReport
    from imitate.session.resimulation import Depth


def replay(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="A session: sessions/NAME.mcap.")],
    physics: Annotated[
        bool, typer.Option("--physics", help="From each trial's recorded commands (the default).")
    ] = False,
    policy: Annotated[
        bool, typer.Option("--policy", help="From each trial's recorded policies; compare the commands too.")
    ] = False,
    whole: Annotated[
        bool, typer.Option("--session", help="All again from seed, settings and decisions; every message.")
    ] = False,
    segment: Annotated[
        int | None, typer.Option("--segment", min=0, help="Only trials of this segment, from 0.")
    ] = None,
    trial: Annotated[
        int | None, typer.Option("--trial", min=0, help="Only trials of this number, from 0.")
    ] = None,
    begin: Annotated[
        float, typer.Option("--from", metavar="S", min=0, help="Only steps from this second of the session.")
    ] = 0.0,
    end: Annotated[
        float, typer.Option("--to", metavar="S", min=0, help="Only steps up to this second.")
    ] = math.inf,
    atol: Annotated[
        float, typer.Option("--atol", min=0, help="Let doubles differ by so much; by default in no bit.")
    ] = 0.0,
    rrd: Annotated[
        Path | None,
        typer.Option("--rrd", metavar="FILE.rrd", help="Also write every step for Rerun's viewer."),
    ] = None,
    layout: Annotated[
        Path | None,
        typer.Option("--foxglove-layout", metavar="FILE.json", help="Also write a layout for Foxglove."),
    ] = None,
    spawn: console.Spawn = False,
    robot: console.RobotPlace = "",
    workers: console.Workers = None,
    as_json: console.Json = False,
    force: console.Force = False,
) -> None:
    """Run a session again and compare every bit.

    Exit code 3 says that a step differs or that the file is damaged.
    """
    import os

    from imitate.errors import UsageError
    from imitate.formats.output import refuse_existing
    from imitate.formats.session_log import summarise
    from imitate.session.replay import Part

    if physics + policy + whole > 1:
        raise UsageError("--physics, --policy and --session are three depths: give one of them.")
    part = Part(segment, None, trial, begin, end)
    if whole and not part.whole:
        raise UsageError(f"--session runs everything again; it cannot be cut to {part}.")
    if spawn and not rrd:
        raise UsageError("--spawn shows what is written for Rerun: add --rrd FILE.rrd.")
    for new in filter(None, (rrd, layout)):
        refuse_existing(new, force)
    total = summarise(session).trials
    count = workers or os.cpu_count() or 1
    report: ReplayReport | RerunReport
    if whole:
        report = _session_again(session, count, robot, atol, total)
    else:
        report = _trials_again(session, count, robot, atol, total, "policy" if policy else "physics", part)
    if rrd:
        _write_view(session, rrd, force, spawn, total)
    if layout:
        _write_layout(session, layout, force)
    replayed.warn(session, report)
    console.write_json(replayed.plain(report)) if as_json else replayed.show(report)
    if report.divergent or report.damage:
        raise typer.Exit(console.Exit.LOSSY)


def _trials_again(
    session: Path, workers: int, robot: str, atol: float, total: int, depth: Depth, part: Part
) -> ReplayReport:
    from imitate.session.replay import replay as run_again

    with console.progress() as bar:
        task = bar.add_task("replaying", total=total)

        def progress(done: int, _: int) -> None:
            bar.update(task, completed=done)

        return run_again(session, progress, workers, robot, depth, part, atol)


def _session_again(session: Path, workers: int, robot: str, atol: float, total: int) -> RerunReport:
    from imitate.learning.trials import executors
    from imitate.session.rerun import rerun

    with console.progress() as bar:
        task = bar.add_task("running it again", total=total)
        return rerun(
            session, executors(workers), robot, atol, lambda done, _: bar.update(task, completed=done)
        )


def _write_view(session: Path, path: Path, force: bool, spawn: bool, total: int) -> None:
    from imitate.events import TrialFinished
    from imitate.formats.session_log import read_session
    from imitate.formats.session_pictures import kept_pictures
    from imitate.session.viewer import Viewer

    with console.progress() as bar, Viewer(path, force, spawn, kept_pictures(session)) as viewer:
        task = bar.add_task("writing for Rerun", total=total)
        for event in read_session(session):
            viewer.write(event)
            bar.advance(task, isinstance(event, TrialFinished))
    console.narrate(f"{path}: open it with `rerun {path}`")


def _write_layout(session: Path, path: Path, force: bool) -> None:
    from imitate.formats.foxglove_layout import write_layout
    from imitate.formats.mcap_contents import contents

    write_layout(path, contents(session).topics, force)
    console.narrate(f"{path}: in Foxglove, Layouts, Import from file")
