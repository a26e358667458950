"""Keeping C code off the standard streams: PyBullet prints there, which would break --json and the screen."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet(*descriptors: int) -> Iterator[None]:
    """Send what the process writes to these file descriptors to /dev/null meanwhile, C code's included.

    Process-wide: enter it where no other thread writes data, as at an import or while a scene is loaded.

    Args:
        descriptors: 1 is stdout, 2 is stderr.
    """
    sys.stdout.flush()
    saved = [os.dup(descriptor) for descriptor in descriptors]
    sink = os.open(os.devnull, os.O_WRONLY)
    try:
        for descriptor in descriptors:
            os.dup2(sink, descriptor)
        yield
    finally:
        sys.stdout.flush()
        for descriptor, original in zip(descriptors, saved, strict=True):
            os.dup2(original, descriptor)
            os.close(original)
        os.close(sink)
