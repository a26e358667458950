"""Frames read ahead of their use: decoding a picture leaves the interpreter free for tracking."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from imitate.rgbd import RgbdFrame

AHEAD = 3
"""frames decoded before they are asked for."""


def ahead(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
    """The same frames in the same order, read by another thread, a few at most in memory at a time."""
    with ThreadPoolExecutor(1) as reader:
        waiting = deque(reader.submit(next, frames, None) for _ in range(AHEAD))
        while (frame := waiting.popleft().result()) is not None:
            waiting.append(reader.submit(next, frames, None))
            yield frame
