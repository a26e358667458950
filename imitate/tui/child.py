"""Long work in a process of its own, so that the screen never waits for it.

Daemons may not own the pool that runs trials, so the child is none. It survives the terminal's hang-up and
looks at every trial whether its parent is still there: then it stops as if asked to, and its files are valid.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.sharedctypes import SynchronizedArray
from multiprocessing.synchronize import Event as Flag
from pathlib import Path
from typing import Any

from imitate.errors import ImitateError, in_words
from imitate.learning.starting import starting

PATIENCE = 0.2
"""s between two looks at what was asked."""

NICENESS = 5
"""added to the child's and its workers' own: a key press comes before trials."""

Place = tuple[int, int]
"""Indices of a segment and of one of its formulations."""
_NOWHERE = (-1, -1)


@dataclass(frozen=True)
class Asked:
    """What the operator has asked of a work; told in the child, asked by the work as often as it can.

    Attributes:
        stop: to end as soon as it may.
        wait: to wait where it asks whether it should stop.
        skipped: of which place the work is to be given up.
    """

    stop: Flag
    wait: Flag
    skipped: SynchronizedArray[int]

    def __call__(self) -> bool:
        """Whether to stop, as is the parent's death."""
        while self.wait.is_set() and not self._ended():
            self.stop.wait(PATIENCE)
        return self._ended()

    def skips(self, segment: int, formulation: int) -> bool:
        """Whether this formulation is to be given up."""
        return (self.skipped[0], self.skipped[1]) == (segment, formulation)

    def _ended(self) -> bool:
        parent = multiprocessing.parent_process()
        return self.stop.is_set() or parent is None or not parent.is_alive()


Work = Callable[[Any, Callable[[Any], None], Asked], None]
"""work(job, emit, asked): a function at the top of a module, since it is pickled."""


def in_child(
    work: Work,
    job: Any,
    should_stop: Callable[[], bool],
    should_wait: Callable[[], bool] = lambda: False,
    to_skip: Callable[[], Place | None] = lambda: None,
    patience: float = PATIENCE,
) -> Iterator[Any]:
    """What ``work`` emits, as it comes.

    Args:
        work, job: what to do and with what; both picklable.
        should_stop: asked every ``patience`` seconds; once true, the child is asked to stop.
        should_wait: asked likewise; while true, the child waits where it asks whether it should stop.
        to_skip: asked likewise: which formulation is to be given up.

    Raises:
        ImitateError: what the child raised; or that it died.
    """
    child, ours, asked = _started(work, job)

    def ask() -> None:
        asked.skipped[:] = to_skip() or _NOWHERE
        asked.wait.set() if should_wait() else asked.wait.clear()
        if should_stop():
            asked.stop.set()

    try:
        while True:
            if not ours.poll(patience):
                ask()
                continue
            kind, value = ours.recv()
            if kind == "done":
                return
            if kind == "error":
                raise ImitateError(value)
            yield value
            ask()
    except EOFError:
        child.join()
        if asked.stop.is_set():
            return
        raise ImitateError(
            f"The process that did the work ended by itself (exit code {child.exitcode}). What was logged "
            "before is whole. Start it again; if it ends again, try with --workers 1."
        ) from None
    finally:
        asked.stop.set()
        ours.close()
        child.join()


def _started(work: Work, job: Any) -> tuple[BaseProcess, Connection, Asked]:
    spawn = multiprocessing.get_context("spawn")
    # multiprocessing hands the present stderr on to a helper process; Textual's own has no file descriptor.
    what = "the process that does the work"
    with Path(os.devnull).open("w") as nowhere, redirect_stderr(nowhere), starting(what):
        ours, theirs = spawn.Pipe(duplex=False)
        asked = Asked(spawn.Event(), spawn.Event(), spawn.Array("i", _NOWHERE))
        child = spawn.Process(target=_child, args=(work, job, theirs, asked), daemon=False)
        child.start()
    theirs.close()  # so that the child's death ends the pipe
    return child, ours, asked


def _child(work: Work, job: Any, out: Connection, asked: Asked) -> None:
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):  # C code prints there, over the screen
        os.dup2(nowhere, stream)
    try:
        work(job, lambda value: out.send(("value", value)), asked)
        out.send(("done", None))
    except BrokenPipeError:
        return
    except Exception as error:
        out.send(("error", in_words(error)))
