"""Streams, exit codes and shared options: stdout is data, stderr is narration."""

from __future__ import annotations

import io
import json
import math
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

import typer

from imitate.errors import ImitateError, OutputError, in_words

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn
    from rich.table import Table

    from imitate.events import Reproduced

SettingsFile = Annotated[
    Path | None,
    typer.Option("--settings", metavar="FILE.toml", help="Settings that differ from the defaults."),
]
MappingFile = Annotated[
    Path | None,
    typer.Option(
        "--mapping", metavar="FILE.toml", help="Which columns, topics or frames are the hand and the objects."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout, for machines.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite the output where it exists.")]
Seed = Annotated[
    int,
    typer.Option("--seed", min=0, max=2**63 - 1, help="The same seed gives the same result, bit for bit."),
]
Workers = Annotated[
    int | None, typer.Option("--workers", min=1, help="Processes that run trials; by default one per core.")
]

RobotPlace = Annotated[
    str,
    typer.Option("--robot", metavar="FILE.toml", help="Where a robot of one's own is now, if it has moved."),
]

Cluster = Annotated[
    str,
    typer.Option("--cluster", metavar="tcp://HOST:PORT", help="Run trials on a cluster of dask.distributed."),
]
ObserveTrials = Annotated[
    bool,
    typer.Option(
        "--observe-trials", help="See the objects in trials by camera and tracker, as the paper did."
    ),
]
Spawn = Annotated[
    bool, typer.Option("--spawn", help="Show what is written for Rerun in its viewer, as it comes.")
]

_WIDE = 1000
"""characters, more than any table needs."""
_CONTROLS = {c: f"\\x{c:02x}" for c in (*range(32), *range(127, 160)) if chr(c) not in "\t\n"}
"""what would steer a terminal, as it is shown instead."""


class Exit(IntEnum):
    """How a process ended. A verb that ends otherwise than DONE raises ``typer.Exit(Exit.LOSSY)``."""

    DONE = 0
    FAILED = 1
    USAGE = 2
    LOSSY = 3
    INTERRUPTED = 130
    TERMINATED = 143


def run(verb: Callable[[], object], debug: bool = False) -> int:
    """Call ``verb``, turn whatever ends it into one message on stderr, and return the exit code.

    Args:
        verb: may return, raise `SystemExit`, or raise anything else.
        debug: show the traceback of an error before its message.
    """
    _prepare_streams()
    try:
        try:
            with _terminated():
                verb()
        finally:
            with _writing():
                sys.stdout.flush()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else Exit.DONE if end.code is None else Exit.FAILED
        if code == Exit.INTERRUPTED:  # typer turns KeyboardInterrupt into this
            narrate("interrupted")
        elif code == Exit.TERMINATED:
            narrate("terminated")
        return code
    except KeyboardInterrupt:
        narrate("interrupted")
        return Exit.INTERRUPTED
    except OutputError as error:
        _give_up(sys.stdout)
        if isinstance(error.__cause__, BrokenPipeError):
            return Exit.FAILED  # the reader, say `head`, has enough
        return _fail(str(error), Exit.FAILED, debug)
    except ImitateError as error:
        return _fail(str(error), error.exit_code, debug)
    except Exception as error:
        words = in_words(error)
        if words.startswith("unexpected") and not debug:
            words = f"{words[:-1]}; run again with --debug to see where."
        return _fail(words, Exit.FAILED, debug)
    return Exit.DONE


def _prepare_streams() -> None:
    # A closed stream's number would be given to the next file that is opened, and C code prints into it.
    while (spare := os.open(os.devnull, os.O_RDONLY)) < 3:
        os.set_inheritable(spare, True)
    os.close(spare)
    sys.stdin = sys.stdin or os.fdopen(0, closefd=False)
    for number, name in enumerate(("stdout", "stderr"), start=1):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, os.fdopen(number, "w", errors="replace", closefd=False))
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # what a terminal has no sign for ends no work


@contextmanager
def _writing() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"stdout cannot be written ({error.strerror or error}).") from error


def _give_up(stream: TextIO) -> None:
    # What is left in its buffer goes nowhere: Python would complain again when it closes the stream.
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextmanager
def _terminated() -> Iterator[None]:
    # SIGTERM ends like Ctrl-C: what is being written is finished first, and no process is left behind.
    def end(*_: object) -> None:
        raise SystemExit(Exit.TERMINATED)

    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may say what a signal does
        return
    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def write(text: str) -> None:
    """One piece of data, on stdout.

    Raises:
        OutputError: stdout is closed or full.
    """
    with _writing():
        typer.echo(text.translate(_CONTROLS))


def write_json(value: Any) -> None:
    """One JSON value on one line of stdout; never NaN, which is not JSON."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding)
    except UnicodeEncodeError:
        text = json.dumps(value, allow_nan=False)
    write(text)


def number(value: float | str) -> float | str:
    """As JSON can say it, which has no NaN and no infinity."""
    return value if isinstance(value, str) or math.isfinite(value) else str(value)


def narrate(text: str, wrapped: bool = False) -> None:
    """One line for the person, on stderr; ``wrapped`` at words, on a terminal, where it is a long one.

    Where stderr cannot be written nothing is said: no work ends for it.
    """
    if wrapped and sys.stderr.isatty():
        import shutil
        import textwrap

        width = shutil.get_terminal_size().columns
        text = textwrap.fill(
            text, width, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
        )
    try:
        typer.echo(text.translate(_CONTROLS), err=True)
    except OSError:
        _give_up(sys.stderr)


def really(reproduced: Reproduced) -> str:
    """Beside what was seen of a reproduction, what was so; empty where nobody watched."""
    return "" if reproduced.really is None else f", seen; {reproduced.really} in the physics"


def table(*columns: str, right: tuple[str, ...] = (), header: bool = True) -> Table:
    """A table with those columns; the ones in ``right`` hold numbers, which are never cut or wrapped."""
    from rich.table import Table

    class Plain(Table):
        def add_row(self, *cells: Any, **how: Any) -> None:
            super().add_row(*(str(cell).translate(_CONTROLS | {10: "\\n"}) for cell in cells), **how)

    made = Plain(*columns, box=None, pad_edge=False, collapse_padding=True, show_header=header)
    for column in made.columns:
        if column.header in right:
            column.justify, column.no_wrap = "right", True
    return made


def show(result: Table) -> None:
    """A table on stdout; where that is no terminal, as wide as it has to be.

    Raises:
        OutputError: stdout is closed or full.
    """
    console = _console()
    if not console.is_terminal:
        console = _console(width=_WIDE)
    with _writing():
        console.print(result, crop=False, soft_wrap=False)


def progress(*more: ProgressColumn) -> Progress:
    """A progress bar on stderr, to be entered as a context; silent where stderr is no terminal.

    Args:
        more: columns at its end.
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = _console(stderr=True)
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f}%"),
        TimeElapsedColumn(),
        *more,
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )


def _console(**how: Any) -> Console:
    # What it prints holds names that other people chose: [left] and :cube: are no markup of ours.
    from rich.console import Console

    return Console(markup=False, emoji=False, **how)


def _fail(message: str, code: int, debug: bool) -> int:
    if debug:
        import traceback

        traceback.print_exc()
    narrate(f"error: {message}")
    return code
