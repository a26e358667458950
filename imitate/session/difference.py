"""In what two sessions differ: settings, what they began from, decisions, and each kind of event."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

from imitate.errors import FileError
from imitate.events import Decided, Event, SessionStarted, TrialFinished
from imitate.formats.session_log import SessionReader
from imitate.formats.session_messages import KINDS, topic_of
from imitate.formats.steps import TrialSteps
from imitate.session.again import place_of
from imitate.session.beside import compare_beside
from imitate.session.compare import Difference, first_difference
from imitate.settings import dotted


@dataclass(frozen=True)
class Setting:
    """A setting that differs; None where a session has none of that name."""

    name: str
    first: Any
    second: Any


@dataclass(frozen=True)
class Topic:
    """How one topic of two sessions compares.

    Attributes:
        name: the topic.
        counts: messages in each.
        number: of the first message that differs, from 0; None where those that both have are equal.
        where: segment, formulation and trial of that message in the first session, as far as it has them.
        difference: in which field.
    """

    name: str
    counts: tuple[int, int]
    number: int | None = None
    where: tuple[int | None, int | None, int | None] = (None, None, None)
    difference: Difference | None = None

    @property
    def equal(self) -> bool:
        """Whether both have the same messages."""
        return self.difference is None and self.counts[0] == self.counts[1]


@dataclass(frozen=True)
class SessionDifference:
    """What differs between two sessions.

    Attributes:
        settings: those that differ.
        decisions: the operator's in each, in words.
        topics: every topic that either has, whether it differs or not.
        damage: what could not be read of each.
    """

    settings: tuple[Setting, ...]
    decisions: tuple[tuple[str, ...], tuple[str, ...]]
    topics: tuple[Topic, ...]
    damage: tuple[tuple[str, ...], tuple[str, ...]]

    @property
    def equal(self) -> bool:
        """Whether all messages are the same."""
        return all(topic.equal for topic in self.topics)


def difference(
    first: Path, second: Path, steps: bool = True, looked: Callable[[int], None] = lambda _: None
) -> SessionDifference:
    """Compares two sessions topic by topic, numbers by their bits.

    Args:
        first, second: the sessions.
        steps: whether the trials' steps are compared too, which takes the longest.
        looked: hears how many trials have been compared.

    Raises:
        FileError: one of them is no session, or one without its start.
    """
    begun = [_start(path) for path in (first, second)]
    damage: tuple[list[str], list[str]] = ([], [])
    topics: list[Topic] = []
    for kind in KINDS:
        readers = [SessionReader(path) for path in (first, second)]
        a, b = (reader.events(steps and kind is TrialFinished, only=(kind,)) for reader in readers)
        topics += _compared(kind, zip_longest(a, b), begun[0].scene.object_names, looked)
        for found, reader in zip(damage, readers, strict=True):
            found += [words for words in reader.damage if words not in found]
    topics += [
        Topic(b.topic, b.counts, b.number, difference=b.difference) for b in compare_beside(first, second)
    ]
    return SessionDifference(
        _settings(begun),
        (_decisions(first), _decisions(second)),
        tuple(topic for topic in topics if any(topic.counts)),
        (tuple(damage[0]), tuple(damage[1])),
    )


def _start(path: Path) -> SessionStarted:
    reader = SessionReader(path)
    for event in reader.events(only=(SessionStarted,)):
        assert isinstance(event, SessionStarted)
        return event
    what = f": {reader.damage[0]}" if reader.damage else ""
    raise FileError(path, f"does not begin with a session's start{what}", "There is nothing to compare.")


def _compared(
    kind: type,
    pairs: Iterator[tuple[Event | None, Event | None]],
    objects: tuple[str, ...],
    looked: Callable[[int], None],
) -> list[Topic]:
    # The steps of a trial are a topic of their own.
    topic, steps = Topic(topic_of(kind), (0, 0)), Topic(topic_of(TrialSteps), (0, 0))
    for number, (a, b) in enumerate(pairs):
        topic = _with_pair(topic, number, _stepless(a), _stepless(b), objects)
        if isinstance(a, TrialFinished) or isinstance(b, TrialFinished):
            steps = _with_pair(steps, number, _with_steps(a), _with_steps(b), objects)
            looked(number + 1)
    return [topic, steps] if kind is TrialFinished else [topic]


def _with_pair(
    topic: Topic, number: int, a: Event | None, b: Event | None, objects: tuple[str, ...]
) -> Topic:
    counts = topic.counts[0] + (a is not None), topic.counts[1] + (b is not None)
    topic = replace(topic, counts=counts)
    if topic.difference or a is None or b is None:
        return topic
    found = first_difference(a, b, objects=objects)
    return replace(topic, number=number, where=place_of(a), difference=found) if found else topic


def _stepless(event: Event | None) -> Event | None:
    return replace(event, record=None) if isinstance(event, TrialFinished) else event


def _with_steps(event: Event | None) -> Event | None:
    return event if isinstance(event, TrialFinished) and event.record is not None else None


def _settings(begun: Sequence[SessionStarted]) -> tuple[Setting, ...]:
    first, second = (dotted(tomllib.loads(started.settings)) for started in begun)
    names = [*first, *(name for name in second if name not in first)]
    pairs = [Setting(name, first.get(name), second.get(name)) for name in names]
    return tuple(pair for pair in pairs if pair.first != pair.second)


def _decisions(path: Path) -> tuple[str, ...]:
    events = SessionReader(path).events(only=(Decided,))
    return tuple(str(event.decision) for event in events if isinstance(event, Decided))
