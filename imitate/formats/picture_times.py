"""When pictures were taken: by one clock, their own stamps or the log's, and what left it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain, islice
from pathlib import Path
from typing import TypeVar

from imitate.demonstration import LONGEST_GAP, span_in_words
from imitate.errors import FileError
from imitate.formats.clock import AHEAD, ASTRAY, SECOND, on_one_clock

T = TypeVar("T")
_CUT = "Keep the part before or after it; `mcap filter` cuts an MCAP file."


def peeked(samples: Iterator[T]) -> tuple[list[T], Iterator[T]]:
    """The first few, and all of them."""
    first = list(islice(samples, AHEAD))
    return first, chain(first, samples)


def steady(
    path: Path, stream: str, pictures: Iterator[T], time: Callable[[T], int], astray: Callable[[T], None]
) -> Iterator[T]:
    """The pictures of a stream but for single ones that are stamped off their clock.

    Args:
        path: of the recording.
        stream: its topic or list, for messages.
        pictures: in nearly the order in which they were taken.
        time: ns of a picture.
        astray: hears of those left out.

    Raises:
        FileError: the clock was set back, or long goes on without a picture.
    """
    first = last = None
    for picture in on_one_clock(pictures, time, astray, SECOND):
        now = time(picture)
        first, last = (now, now) if first is None or last is None else (first, last)
        if last - now > ASTRAY * SECOND:
            raise _jump(path, f"{stream} goes back in time by", last - now, last - first)
        if now - last > LONGEST_GAP * SECOND:
            raise _jump(path, f"{stream} has no picture for", now - last, last - first)
        last = max(last, now)
        yield picture


def _jump(path: Path, what: str, by: int, after: int) -> FileError:
    where = f"{what} {span_in_words(by / SECOND)}, {after / SECOND:.2f} s after its first"
    return FileError(path, f"{where}: its clock was set, or it goes on another time", _CUT)
