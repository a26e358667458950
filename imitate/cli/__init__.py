"""The command line: a file per verb. `console` owns streams and exit codes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any

import typer

from imitate.cli import console
from imitate.cli.demonstrate import demonstrate
from imitate.cli.diff import diff
from imitate.cli.experiment import experiment
from imitate.cli.export import export
from imitate.cli.info import info
from imitate.cli.learn import learn
from imitate.cli.observe import observe
from imitate.cli.recover import recover
from imitate.cli.replay import replay
from imitate.cli.reproduce import reproduce
from imitate.cli.resume import resume
from imitate.cli.segment import segment
from imitate.cli.sessions import sessions
from imitate.cli.tui import tui
from imitate.errors import ImitateError, in_words

app = typer.Typer(
    name="imitate",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # rich costs 0.1 s, which would be most of --help
    context_settings={"help_option_names": ["-h", "--help"]},
)

VERBS: tuple[Callable[..., None], ...] = (
    tui,
    demonstrate,
    observe,
    segment,
    learn,
    reproduce,
    replay,
    resume,
    recover,
    info,
    diff,
    export,
    experiment,
    sessions,
)
"""Functions, one per verb, in the order in which --help lists them. Their modules import typer alone."""


def _whole(verb: Callable[..., None]) -> Callable[..., None]:
    # click takes any broken pipe for that of stdout, and ends without a word.
    @wraps(verb)
    def run(*words: Any, **options: Any) -> None:
        try:
            verb(*words, **options)
        except BrokenPipeError as error:
            raise ImitateError(in_words(error)) from error

    return run


for _verb in VERBS:
    app.command(_verb.__name__, epilog="With --debug, an error shows its traceback.")(_whole(_verb))


def _print_version(wanted: bool) -> None:
    if wanted:
        from imitate import __version__

        console.write(f"imitate {__version__}")
        raise typer.Exit


@app.callback()
def _imitate(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", help="Show the traceback of an error; anywhere on the line.")
    ] = False,
) -> None:
    """Teach a robot a manipulation task by showing it once."""


def main(arguments: list[str] | None = None) -> None:
    """Entry point: runs one verb and leaves the process with its exit code.

    Args:
        arguments: the command line without the program's name; by default the process's own.
    """
    given = sys.argv[1:] if arguments is None else arguments
    words = [word for word in given if word != "--debug"]
    code = console.run(lambda: app(words, prog_name="imitate"), debug="--debug" in given)
    raise SystemExit(code)
