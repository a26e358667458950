"""`imitate learn`: the whole session, headless."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.events import Event
    from imitate.session.session import Request


def learn(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A demonstration (.npz, .mcap) or an RGB-D recording.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE.mcap",
            help="The session; by default in sessions/. With --seeds, each is FILE-SEED.mcap.",
        ),
    ] = None,
    mode: Annotated[
        str | None,
        typer.Option("--mode", metavar="robust|faithful", help="Settings: robust (default) or the paper's."),
    ] = None,
    rrd: Annotated[bool, typer.Option(help="Write the Rerun file beside the session.")] = True,
    spawn: console.Spawn = False,
    decisions: Annotated[
        Path | None,
        typer.Option("--decisions", metavar="FILE.json", help="Your decisions, applied to what is found."),
    ] = None,
    mapping_file: console.MappingFile = None,
    robot: Annotated[
        str | None,
        typer.Option("--robot", metavar="NAME|FILE.toml", help="The arm: panda, iiwa, xarm6, or one's own."),
    ] = None,
    symmetric: Annotated[
        list[str] | None,
        typer.Option("--symmetric", metavar="NAME", help="An object that may end turned, if it looks alike."),
    ] = None,
    observe_trials: console.ObserveTrials = False,
    settings_file: console.SettingsFile = None,
    seed: console.Seed = 0,
    seeds: Annotated[
        str,
        typer.Option(
            "--seeds", metavar="0-19", help="A session for each of these seeds, --workers of them at a time."
        ),
    ] = "",
    workers: console.Workers = None,
    cluster: console.Cluster = "",
    steps: Annotated[
        bool, typer.Option(help="Keep every step; without, the file is small and cannot be replayed.")
    ] = True,
    embed: Annotated[
        bool, typer.Option("--embed-recording", help="Keep the recording's pictures in the session.")
    ] = False,
    as_json: console.Json = False,
    force: console.Force = False,
) -> None:
    """Learn a task from one demonstration, and reproduce it.

    Exit code 3 says that it was not reproduced, and stderr which skill failed and what to try; or that more
    than a tenth of a recording's frames are missing from it.
    """
    import os

    from imitate.cli.sweep import seeds_of, sweep
    from imitate.formats.decisions import read_decisions
    from imitate.formats.mapping import read_mapping
    from imitate.formats.output import free_name, require_mcap
    from imitate.session.session import Request
    from imitate.settings import load_settings

    _refuse_both(seed, seeds, spawn, rrd)
    swept = seeds_of(seeds) if seeds else ()
    settings = load_settings(settings_file, _given(mode, robot, symmetric, observe_trials))
    if output:
        require_mcap(output)
    log = output or free_name(Path("sessions"), f"{file.stem}-{seed}", ".mcap")
    request = Request(
        file,
        settings,
        seed,
        workers or os.cpu_count() or 1,
        read_decisions(decisions) if decisions else (),
        mapping=read_mapping(mapping_file) if mapping_file else None,
        log=log,
        rrd=log.with_suffix(".rrd") if rrd else None,
        force=force,
        cluster=cluster,
        steps=steps,
        spawn=spawn,
        embed=embed,
    )
    if swept and output:
        sweep(request, {k: output.with_name(f"{output.stem}-{k}.mcap") for k in swept}, as_json)
    elif swept:
        sweep(request, {k: free_name(Path("sessions"), f"{file.stem}-{k}", ".mcap") for k in swept}, as_json)
    else:
        _learn(request, log, as_json)


def _refuse_both(seed: int, seeds: str, spawn: bool, rrd: bool) -> None:
    # Options that exclude each other.
    from imitate.errors import UsageError

    if seeds and seed:
        raise UsageError(f"--seed {seed} and --seeds {seeds}: give one of them.")
    if spawn and (seeds or not rrd):
        raise UsageError(
            f"--spawn shows one session as it is written: leave {'--seeds' if seeds else '--no-rrd'} out."
        )


def _given(
    mode: str | None, robot: str | None, symmetric: list[str] | None, observe_trials: bool
) -> dict[str, Any]:
    # Settings that the command line names; what it does not name is not overridden.
    learning: dict[str, Any] = {"symmetric": symmetric} if symmetric else {}
    learning |= {"observe_trials": True} if observe_trials else {}
    given: dict[str, Any] = {"mode": mode} if mode else {}
    given |= {"world": {"robot": robot}} if robot else {}
    return given | ({"learning": learning} if learning else {})


def _learn(request: Request, log: Path, as_json: bool) -> None:
    from imitate.cli.following import follow
    from imitate.formats.output import refuse_existing
    from imitate.session.session import run
    from imitate.session.source import Source

    for path in filter(None, (request.log, request.rrd)):
        refuse_existing(path, request.force)
    much_lost = False

    def heard(source: Source) -> None:
        nonlocal much_lost
        much_lost = source.much_lost
        for note in source.notes:
            console.narrate(f"{request.source}: {note}")

    def events(watching: Callable[[int, int], None]) -> Iterator[Event]:
        return _sized(run(request, watching=watching, heard=heard), request)

    follow(events, log, request.rrd, as_json)
    if much_lost:
        raise typer.Exit(console.Exit.LOSSY)


def _sized(events: Iterator[Event], request: Request) -> Iterator[Event]:
    # The same events; before the first trial, what is doubted and how large the log may become.
    from imitate.events import Decided, FormulationStarted, Segmented, SessionStarted
    from imitate.segmentation import hasty
    from imitate.session.size import expected_bytes

    started, settled = None, None
    for event in events:
        if isinstance(event, SessionStarted):
            started = event
        elif isinstance(event, Segmented | Decided):
            settled = event
        elif isinstance(event, FormulationStarted) and started and settled:
            for carry in hasty(settled.segments, request.settings.segmentation):
                console.narrate(str(carry))
            expected = expected_bytes(settled.segments, started.scene, request.settings, request.steps)
            console.narrate(f"{request.log} may become about {expected / 1e6:,.0f} MB")
            started = None
        yield event
