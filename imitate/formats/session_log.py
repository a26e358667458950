"""A session's MCAP → its events.

What its messages are, `imitate.formats.session_messages` says. Reading goes by the /imitate/ topics alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from google.protobuf.message import DecodeError, Message

from imitate import __version__
from imitate.errors import FileError
from imitate.events import Event, TrialFinished
from imitate.formats.kind import METADATA
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.messages import decode, message_class
from imitate.formats.session_messages import KINDS, Stamped, topic_of
from imitate.formats.session_pictures import TOPICS as PICTURES
from imitate.formats.steps import TrialSteps, unpack_record
from imitate.record import TrialRecord

SCHEMA = 1
"""version of what this module writes; a reader refuses a newer one."""


@dataclass(frozen=True)
class SessionSummary:
    """A session at a glance.

    Attributes:
        complete: whether it ran to its end.
        trials: how many finished.
        events: kind → count.
        seconds: simulated.
        version: of imitate, that wrote it.
        steps: whether the steps of its trials were to be kept.
        damage: as in `imitate.formats.mcap_file.Contents`.
    """

    complete: bool
    trials: int
    events: Mapping[str, int]
    seconds: float
    version: str
    steps: bool
    damage: tuple[str, ...]


def summarise(path: Path | str) -> SessionSummary:
    """What is inside a session's file, from its index alone where it has one.

    Raises:
        FileError: no such file, not a session, or one of a newer schema.
    """
    inside = contents(Path(path))
    _check_schema(Path(path), inside.metadata)
    events = {cls.__name__: inside.topics.get(topic_of(cls), ("", 0))[1] for cls in KINDS}
    return SessionSummary(
        complete=events["SessionFinished"] > 0 and not inside.damage,
        trials=events["TrialFinished"],
        events=events,
        seconds=inside.end / 1e9,
        version=inside.metadata[METADATA].get("imitate", "unknown"),
        steps=inside.metadata[METADATA].get("steps", "kept") == "kept",
        damage=inside.damage,
    )


@dataclass(frozen=True)
class Told:
    """An event as a session's file tells it.

    Attributes:
        event: with its record, where it has one.
        time: nanoseconds of the session's clock; of a trial, its end.
        beside: the messages for people's tools since the event before.
    """

    event: Event
    time: int
    beside: tuple[Stamped, ...] = ()


class SessionReader:
    """Reads a session back.

    Attributes:
        damage: what could not be read, in words; fills while `events` runs.

    Raises:
        FileError: no such file, not a session, or one of a newer schema.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._file = McapReader(self.path)
        self.damage: list[str] = self._file.damage
        self._types: dict[str, type[Message]] = {}
        self._owners: dict[int, TrialRecord] = {}

    def events(self, steps: bool = True, only: Sequence[type] = KINDS) -> Iterator[Event]:
        """The events as they were written, arrays equal bit for bit; of a cut file all that were flushed.

        Args:
            steps: False leaves every trial's record None, which is much faster.
            only: kinds that are wanted; what holds none of them is not unpacked.
        """
        steps = steps and TrialFinished in only
        return (told.event for told in self.told(steps, beside=False, only=only))

    def told(self, steps: bool = True, beside: bool = True, only: Sequence[type] = KINDS) -> Iterator[Told]:
        """The events with their times.

        Args:
            steps: as for `events`.
            beside: also the messages for people's tools: then it is everything that is in the file.
            only: as for `events`.
        """
        kinds = {topic_of(cls): cls for cls in (*only, *((TrialSteps,) if steps else ()))}
        recorded: TrialSteps | None = None
        others: list[Stamped] = []
        checked = False
        for message in self._file.messages(None if beside else kinds):
            if not checked:  # the metadata comes before the first message
                _check_schema(self.path, self._file.metadata)
                checked = True
            if message.topic in PICTURES:
                continue
            if message.topic not in kinds:
                others.append((message.topic, message.data, message.time))
                continue
            event = self._decoded(message, kinds[message.topic])
            if isinstance(event, TrialSteps):
                recorded = event
                continue
            if isinstance(event, TrialFinished) and recorded is not None:
                event, recorded = self._with_record(event, recorded), None
            yield Told(event, message.time, tuple(others))
            others.clear()
        if not checked:
            _check_schema(self.path, self._file.metadata)

    def _decoded(self, message: RawMessage, cls: type) -> Any:
        try:
            if message.topic not in self._types:
                self._types[message.topic] = message_class(message.schema_name, message.schema)
            return decode(cls, self._types[message.topic].FromString(message.data))
        except (ValueError, TypeError, DecodeError) as error:
            raise FileError(
                self.path, f"topic {message.topic} cannot be read ({error})", "The file is damaged."
            ) from None

    def _with_record(self, event: TrialFinished, recorded: TrialSteps) -> TrialFinished:
        key = (event.segment, event.formulation, event.trial)
        lost = key != (recorded.segment, recorded.formulation, recorded.trial)
        if lost or (recorded.shared and recorded.owner not in self._owners):
            self.damage.append(f"the steps of trial {event.trial} of segment {event.segment} are missing")
            return event
        try:
            record = unpack_record(recorded, self._owners.get(recorded.owner))
            if recorded.owns:
                self._owners[recorded.number] = record
            return replace(event, record=record)
        except (ValueError, TypeError, IndexError) as error:
            raise FileError(
                self.path,
                f"the steps of trial {event.trial} cannot be read ({error})",
                "The file is damaged.",
            ) from None


def read_session(path: Path | str, steps: bool = True) -> Iterator[Event]:
    """The events of a session; see `SessionReader`, which also tells what was lost of a damaged file."""
    return SessionReader(path).events(steps)


def _check_schema(path: Path, metadata: Mapping[str, Mapping[str, str]]) -> None:
    ours = metadata.get(METADATA, {})
    if ours.get("kind") != "session":
        raise FileError(path, "is not a session of imitate", "`imitate info` says what it is.")
    schema = ours.get("schema", "")
    if not schema.isdecimal() or int(schema) > SCHEMA:
        raise FileError(
            path,
            f"is a session of schema {schema or 'unknown'}, written by imitate "
            f"{ours.get('imitate', 'unknown')}; imitate {__version__} reads up to schema {SCHEMA}",
            "Install a newer imitate.",
        )
