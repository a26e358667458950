"""``imitate tui``: the guided session in the terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from imitate.cli.console import MappingFile, Seed, SettingsFile, Workers


def tui(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="A recording, a demonstration or a session.")
    ] = None,
    seed: Seed = 0,
    workers: Workers = None,
    mapping: MappingFile = None,
    settings: SettingsFile = None,
    keys: Annotated[
        Path | None,
        typer.Option("--keys", metavar="FILE.toml", help='Keys of your own, as learn.stop = "S".'),
    ] = None,
) -> None:
    """The guided session, in the terminal.

    See every step, and overrule it where it is wrong.
    """
    import os
    import sys

    from imitate.cli import console
    from imitate.errors import UsageError
    from imitate.formats.mapping import read_mapping
    from imitate.settings import load_settings

    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise UsageError("imitate tui needs a terminal. Without one: imitate learn FILE.")
    chosen = load_settings(settings)
    if mapping and not file:
        raise UsageError("--mapping says what the columns of a file mean: give the FILE as well.")
    said = read_mapping(mapping) if mapping else None
    from imitate.tui.app import ImitateApp
    from imitate.tui.engine import with_mapping
    from imitate.tui.keys import read_keys
    from imitate.tui.photo import photo_of_terminal

    engine = with_mapping(file, said) if file and said else None
    own = read_keys(keys) if keys else None
    photo = photo_of_terminal(console.narrate)
    app = ImitateApp(file, chosen, seed, workers or os.cpu_count() or 1, engine, photo=photo, keys=own)
    app.run()
    if app.state.running:
        console.narrate("finishing the present trial …")
