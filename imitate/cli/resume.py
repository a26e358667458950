"""`imitate resume`: go on where a session stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from imitate.cli import console


def resume(
    session: Annotated[Path, typer.Argument(metavar="SESSION", help="A session that was stopped or cut.")],
    rrd: Annotated[bool, typer.Option(help="Write the Rerun file beside the session anew.")] = True,
    robot: console.RobotPlace = "",
    workers: console.Workers = None,
    cluster: console.Cluster = "",
    as_json: console.Json = False,
) -> None:
    """Go on where a session stopped, to the end that it would have had.

    Exit code 3 says that the task was not reproduced, as with learn.
    """
    import os

    from imitate.cli.following import follow
    from imitate.formats.session_log import summarise
    from imitate.learning.trials import executors
    from imitate.session.resume import Resumption
    from imitate.session.resume import resume as go_on

    summary = summarise(session)
    if summary.complete:
        console.narrate(f"{session}: has ended; nothing is left to do and nothing was changed.")
        if as_json:
            console.write_json({"session": str(session), "trials": summary.trials, "resumed": False})
        return
    console.narrate(f"{session}: {summary.trials:,} trials are recorded")
    view = session.with_suffix(".rrd") if rrd else None
    resumption = Resumption(session, executors(workers or os.cpu_count() or 1, cluster), robot, view)
    follow(lambda _: go_on(resumption), session, view, as_json)
