"""Keeping C code off stdout: PyBullet prints warnings there, which would break --json and the screen."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet_stdout() -> Iterator[None]:
    """Send what the process writes to file descriptor 1 to /dev/null meanwhile, C code's output included.

    Process-wide: enter it where no other thread writes data, as at an import or while a scene is loaded.
    """
    sys.stdout.flush()
    saved = os.dup(1)
    sink = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(sink, 1)
        yield
    finally:
        sys.stdout.flush()
        os.dup2(saved, 1)
        os.close(saved)
        os.close(sink)
