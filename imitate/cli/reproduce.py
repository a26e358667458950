"""`imitate reproduce`: a session's learned options from new starts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from imitate.cli import console


def reproduce(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="A finished session (.mcap).")],
    trials: Annotated[int, typer.Option("--trials", min=1, help="Perturbed starts.")] = 20,
    seed: console.Seed = 0,
    shift: Annotated[
        float | None,
        typer.Option("--shift", metavar="M", min=0, help="How far each object is moved, at most; 0.02."),
    ] = None,
    turn: Annotated[
        float | None,
        typer.Option("--turn", metavar="DEGREES", min=0, help="How far each is turned, at most; 15."),
    ] = None,
    observe_trials: console.ObserveTrials = False,
    robot: console.RobotPlace = "",
    workers: console.Workers = None,
    cluster: console.Cluster = "",
    as_json: console.Json = False,
) -> None:
    """Run a learned task from new starts.

    Exit code 3 says that it succeeds in less than α of them.
    """
    import os

    from imitate.events import Reproduced, TrialFinished
    from imitate.learning.trials import executors
    from imitate.session.reproduction import reproduce_session

    result: Reproduced | None = None
    with console.progress() as bar:
        task = bar.add_task("reproducing", total=trials)
        factory = executors(workers or os.cpu_count() or 1, cluster)
        for event in reproduce_session(
            session, trials, seed, factory, shift, turn, robot, observe_trials or None
        ):
            if isinstance(event, TrialFinished):
                bar.advance(task)
                if event.failure:
                    console.narrate(f"start {event.trial + 1}: {event.failure}")
            elif isinstance(event, Reproduced):
                result = event
    assert result is not None
    if result.outside:
        console.narrate(
            f"{result.outside_failed} of {result.outside} starts failed in which a skill began outside its "
            "initiation set"
        )
    if as_json:
        keys = ("successes", "trials", "low", "high")
        really = {} if result.really is None else {"really": result.really}
        console.write_json({key: getattr(result, key) for key in keys} | really)
    else:
        console.write(
            f"{result.successes} of {result.trials} starts (95 % interval {result.low:.2f}–{result.high:.2f})"
            f"{console.really(result)}"
        )
    if not result.reproduced:
        raise typer.Exit(console.Exit.LOSSY)
