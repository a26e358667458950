"""`imitate learn --seeds`: a session for each seed, as a table or JSON."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from rich.progress import ProgressColumn

    from imitate.session.progress import Progress
    from imitate.session.session import Request
    from imitate.session.sweep import Board, Swept

_MOST = 1000
"""sessions in one sweep."""


def seeds_of(text: str) -> tuple[int, ...]:
    """Seeds as written, such as 0-19 or 3,7,10-12; each once, in that order.

    Raises:
        UsageError: not written so, or more than a sweep takes.
    """
    from imitate.errors import UsageError

    seeds: dict[int, None] = {}
    for part in text.split(","):
        written = re.fullmatch(r"([0-9]{1,19})(?:-([0-9]{1,19}))?", part.strip())
        low, high = (int(written[1]), int(written[2] or written[1])) if written else (1, 0)
        if high < low:
            raise UsageError(f"--seeds {text}: {part.strip()!r} is no seed. Write them as 0-19 or 3,7,10-12.")
        if high - low + len(seeds) >= _MOST or high >= 2**63:
            raise UsageError(f"--seeds {text}: at most {_MOST} sessions in one sweep, each seed below 2⁶³.")
        seeds |= dict.fromkeys(range(low, high + 1))
    return tuple(seeds)


def sweep(request: Request, logs: dict[int, Path], as_json: bool) -> None:
    """Runs ``request`` with each seed of ``logs`` (seed → the session's file); shows what came of each.

    Args:
        request: its ``workers`` is how many sessions run at a time; an ``rrd`` asks for one beside each log.

    Raises:
        ImitateError: what would fail every session; said once, before any where it shows by then.
    """
    from imitate.errors import ImitateError
    from imitate.formats.kind import kind_of
    from imitate.learning.trials import executors
    from imitate.session.sweep import Board, session_pool
    from imitate.session.sweep import sweep as run

    if not request.mapping:
        kind_of(request.source)
    executors(request.workers, request.cluster)
    requests = [
        replace(request, seed=k, workers=0, log=log, rrd=log.with_suffix(".rrd") if request.rrd else None)
        for k, log in logs.items()
    ]
    began = time.monotonic()
    board = Board(len(requests))
    with console.progress(_running(board, tuple(logs))) as bar:
        task = bar.add_task(f"0 of {len(logs)} sessions", total=len(logs))

        def finished(swept: Swept) -> None:
            bar.advance(task)
            bar.update(task, description=f"{bar.tasks[task].completed:.0f} of {len(logs)} sessions")
            console.narrate(f"seed {swept.request.seed}: {_says(swept)}")

        results = run(requests, session_pool(request.workers, board), finished)
    if all(swept.error for swept in results):
        raise ImitateError(results[0].error)
    sources = [swept.source for swept in results if swept.source]  # all of one file
    for note in sources[0].notes if sources else ():
        console.narrate(f"{request.source}: {note}")
    _show(results, round(time.monotonic() - began, 3), as_json)
    if not all(swept.reproduced for swept in results) or any(source.much_lost for source in sources):
        raise typer.Exit(console.Exit.LOSSY)


def _running(board: Board, seeds: tuple[int, ...]) -> ProgressColumn:
    # A column that says, whenever the bar is drawn, where each session is.
    from rich.progress import ProgressColumn, Task
    from rich.text import Text

    class Running(ProgressColumn):
        def render(self, _: Task) -> Text:
            now = board.running().items()
            return Text("; ".join(f"seed {seeds[k]}: skill {skill}, {n} trials" for k, (skill, n) in now))

    return Running()


def _says(swept: Swept) -> str:
    if swept.error or not swept.progress.finished:
        return swept.error or "stopped"
    return swept.progress.finished.advice or f"reproduced, {swept.wall_s:.0f} s"


def _show(results: tuple[Swept, ...], seconds: float, as_json: bool) -> None:
    reproduced = sum(swept.reproduced for swept in results)
    if as_json:
        sessions = [_report(swept) for swept in results]
        console.write_json({"sessions": sessions, "reproduced": reproduced, "wall_s": seconds})
        return
    table = console.table("seed", "reproduced", "trials", "s", "session", right=("seed", "s"))
    for swept in results:
        told = _reproduced(swept.progress) if not swept.error else "failed"
        where = str(swept.request.log) if not swept.error else swept.error
        trials = _trials(swept.progress)
        table.add_row(str(swept.request.seed), told, trials, f"{swept.wall_s:.0f}", where)
    console.show(table)
    console.write(f"{reproduced} of {len(results)} sessions reproduced the task, {seconds:.0f} s")


def _report(swept: Swept) -> dict[str, Any]:
    # As of a single session; with why it failed, where it did.
    from imitate.session.progress import learn_report

    report = learn_report(swept.progress, str(swept.request.log), swept.wall_s)
    return report | {"seed": swept.request.seed} | ({"error": swept.error} if swept.error else {})


def _reproduced(progress: Progress) -> str:
    r = progress.reproduced
    if r is None:
        return "no: a skill was not learned"
    return f"{'yes' if r.reproduced else 'no'}: {r.successes} of {r.trials}"


def _trials(progress: Progress) -> str:
    # Of each formulation of a skill, the skills apart: 1 | 15 + 20.
    return " | ".join(" + ".join(str(a.explored) for a in skill.attempts) for skill in progress.skills)
