"""The command line: a file per verb. `console` owns streams and exit codes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Annotated

import typer

from imitate.cli import console
from imitate.cli.demonstrate import demonstrate
from imitate.cli.observe import observe
