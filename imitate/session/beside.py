"""What sessions keep for people's tools (poses shown, transforms, costs, pictures), compared byte by byte."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import blake2b
from itertools import islice
from pathlib import Path

from imitate.errors import FileError
from imitate.formats.flat import rows
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader
from imitate.formats.session_messages import KINDS, topic_of
from imitate.formats.steps import TrialSteps
from imitate.session.compare import Difference

_OWN = {topic_of(kind) for kind in (*KINDS, TrialSteps)}
_Mark = tuple[int, bytes]
"""a message's log time in nanoseconds, and a digest of it."""


@dataclass(frozen=True)
class Beside:
    """How a topic that is no event's compares.

    Attributes:
        topic: its name.
        counts: messages in each session.
        number: of the first message that differs, from 0; None where those that both have are equal.
        difference: in which field.
    """

    topic: str
    counts: tuple[int, int]
    number: int | None = None
    difference: Difference | None = None


def compare_beside(first: Path, second: Path) -> Iterator[Beside]:
    """Every topic of either session that is no event's."""
    marks = [_marks(path) for path in (first, second)]
    for topic in sorted({*marks[0], *marks[1]}):
        a, b = (of.get(topic, []) for of in marks)
        counts = len(a), len(b)
        number = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), None)
        if number is None:
            yield Beside(topic, counts)
        else:
            yield Beside(topic, counts, number, _difference(topic, number, first, second))


def _marks(path: Path) -> dict[str, list[_Mark]]:
    topics = contents(path).topics.keys() - _OWN
    found: dict[str, list[_Mark]] = defaultdict(list)
    for message in McapReader(path).messages(topics):
        found[message.topic].append((message.time, blake2b(message.data, digest_size=16).digest()))
    return found


def _difference(topic: str, number: int, first: Path, second: Path) -> Difference:
    try:
        a, b = (next(islice(rows(path, topic), number, None)) for path in (first, second))
    except FileError:  # it cannot be decoded: that its bytes differ is all that is known
        a, b = {}, {}
    for field in (*a, *(name for name in b if name not in a)):
        x, y = a.get(field, "none"), b.get(field, "none")
        if repr(x) != repr(y):  # in which −0.0 is not 0.0, and a NaN is one
            return Difference(field, x, y)
    return Difference("bytes", "some", "others")
