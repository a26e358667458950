"""Starting processes on a system that may allow no more of them."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import active_children
from typing import Any

from imitate.errors import ImitateError


@contextmanager
def starting(what: str) -> Iterator[None]:
    """Ends what the block has started where it could not start all of it.

    Raises:
        ImitateError: the system starts no more processes or threads.
    """
    before = set(active_children())
    warnings.filterwarnings("ignore", "resource_tracker: process died")  # said below, where it matters
    try:
        yield
    except (OSError, RuntimeError) as error:
        for child in set(active_children()) - before:  # it waits for work, and our own end would wait for it
            child.kill()
            child.join()
        sys.unraisablehook = _unless_broken_pipe
        why = f" ({error.strerror})" if isinstance(error, OSError) and error.strerror else ""
        raise ImitateError(
            f"{what} cannot be started{why}. The system may allow no more processes (ulimit -u), or have no "
            "memory left for them: end others, or try with --workers 1."
        ) from error


def _unless_broken_pipe(unraisable: Any) -> None:
    # What is half made complains once more when it is thrown away.
    if not isinstance(unraisable.exc_value, BrokenPipeError):
        sys.__unraisablehook__(unraisable)
