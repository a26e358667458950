"""Events ⇄ the session's MCAP: one self-contained file, appended and flushed while a session runs.

Each kind of event has its topic /imitate/<kind>, with a protobuf message derived from its dataclass; the
steps of a trial are the message /imitate/trial_steps just before the trial's own. /tf, /costs and
/demonstration/… are for people's tools and are not read back. Log times are nanoseconds of simulated time:
the demonstration, then trial after trial. Nothing in the file tells the time of day, so that equal sessions
are equal.
"""

from __future__ import annotations

import re
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from google.protobuf.message import DecodeError, Message

from imitate import __version__
from imitate.errors import FileError
from imitate.events import (
    Decided,
    Evaluated,
    Event,
    OptionLearned,
    Reproduced,
    Segmented,
    SessionFinished,
    SessionStarted,
    TrialFinished,
)
from imitate.formats import columns
from imitate.formats.curves import curve_channel, curve_message, transforms
from imitate.formats.kind import METADATA
from imitate.formats.mcap_file import McapReader, McapWriter, RawMessage, contents, protobuf_channel
from imitate.formats.messages import decode, describe, encode, message_class
from imitate.formats.output import refuse_existing
from imitate.formats.pose_topics import pose_channels, pose_messages
from imitate.formats.steps import Prefixes, TrialSteps, pack_record, unpack_record
from imitate.record import TrialRecord

SCHEMA = 1
"""version of what this module writes; a reader refuses a newer one."""
SHOWN_PER_SECOND = 30
"""poses per second of a trial on the topic for people's tools."""
_KINDS: tuple[type, ...] = typing.get_args(Event)
_MESSAGES = describe((*_KINDS, TrialSteps), omit=frozenset({(TrialFinished, "record")}))
_FLUSHED = (
    SessionStarted,
    Segmented,
    Decided,
    TrialFinished,
    Evaluated,
    OptionLearned,
    Reproduced,
    SessionFinished,
)


def topic_of(cls: type) -> str:
    """The topic of a kind of event: /imitate/trial_finished for TrialFinished."""
    return "/imitate/" + re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()


class SessionWriter:
    """Writes a session while it runs; a listener of the session's events.

    Every finished trial, decision and evaluation is in the file when `write` returns, should the process die.

    Args:
        path: the new file, in a folder that is made when it does not exist.
        force: replace what is there.

    Raises:
        FileError: the file exists and ``force`` is not given, or it cannot be written.
    """

    def __init__(self, path: Path | str, force: bool = False) -> None:
        self.path = Path(path)
        refuse_existing(self.path, force)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(self.path, f"its folder cannot be made ({error.strerror})") from None
        try:
            if force:
                self.path.unlink(missing_ok=True)
            self._stream: IO[bytes] = self.path.open("xb")
        except FileExistsError:
            raise FileError(self.path, "exists already", "Another session may be writing it.") from None
        except OSError as error:
            raise FileError(self.path, f"cannot be written ({error.strerror})") from None
        self._mcap: McapWriter | None = None
        self._names: tuple[str, ...] = ()
        self._prefixes = Prefixes()
        self._now = 0

    def write(self, event: Event) -> None:
        """Appends one event; the first must be SessionStarted.

        Raises:
            FileError: the disk is full or the file cannot be written for another reason.
        """
        try:
            if isinstance(event, SessionStarted):
                self._start(event)
            if self._mcap is None:
                raise ValueError("the first event of a session is SessionStarted")
            if isinstance(event, TrialFinished):
                self._write_trial(self._mcap, event)
            self._mcap.write(topic_of(type(event)), encode(event, _MESSAGES), self._now)
            if isinstance(event, SessionStarted):
                self._show_demonstration(self._mcap, event)
            if isinstance(event, _FLUSHED):
                self._mcap.flush()
        except OSError as error:
            raise self._unwritable(error) from error

    def close(self) -> None:
        """Writes the summary; the file is a whole MCAP file after this, the session complete or not."""
        if self._stream.closed:
            return
        try:
            try:
                if self._mcap is not None:
                    self._mcap.finish()
            finally:
                self._stream.close()
        except OSError as error:
            raise self._unwritable(error) from error

    def __enter__(self) -> SessionWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _unwritable(self, error: OSError) -> FileError:
        return FileError(
            self.path,
            f"cannot be written any more ({error.strerror})",
            "Every trial flushed before is in it.",
        )

    def _start(self, event: SessionStarted) -> None:
        self._names = event.scene.object_names
        channels = [protobuf_channel(topic_of(cls), _MESSAGES[cls]) for cls in (*_KINDS, TrialSteps)]
        channels += [protobuf_channel("/tf", FrameTransforms), curve_channel("/costs")]
        channels += pose_channels(event.demonstration.object_names)
        metadata = {
            METADATA: {
                "kind": "session",
                "schema": str(SCHEMA),
                "imitate": __version__,
                "columns": columns.__doc__ or "",
            }
        }
        # a chunk ends where it is flushed: after a trial
        self._mcap = McapWriter(self._stream, channels, metadata, chunk_size=1 << 26)

    def _show_demonstration(self, mcap: McapWriter, event: SessionStarted) -> None:
        first = None
        for topic, message, time in pose_messages(event.demonstration):
            first = time if first is None else first
            mcap.write(topic, message, time - first)
            self._now = time - first

    def _write_trial(self, mcap: McapWriter, event: TrialFinished) -> None:
        if event.record is not None:
            tick = event.record.time_step * 1e9
            for step, message in transforms(event.record, self._names, SHOWN_PER_SECOND):
                mcap.write("/tf", message, self._now + round((step + 1) * tick))
            self._now += round(event.record.steps * tick)
            key = (event.segment, event.formulation, event.trial)
            steps = pack_record(event.record, key, *self._prefixes.take(event.record))
            mcap.write(topic_of(TrialSteps), encode(steps, _MESSAGES), self._now)
            mcap.flush()  # a chunk of its own, which who wants no steps need not unpack
        cost = event.cost
        values = (cost.total, cost.terminal, cost.acceleration, cost.gripper)
        mcap.write("/costs", curve_message("total, terminal, acceleration, gripper", values), self._now)


@dataclass(frozen=True)
class SessionSummary:
    """A session at a glance.

    Attributes:
        complete: whether it ran to its end.
        trials: how many finished.
        events: kind → count.
        seconds: simulated.
        version: of imitate, that wrote it.
        damage: as in `imitate.formats.mcap_file.Contents`.
    """

    complete: bool
    trials: int
    events: Mapping[str, int]
    seconds: float
    version: str
    damage: tuple[str, ...]


def summarise(path: Path | str) -> SessionSummary:
    """What is inside a session's file, from its index alone where it has one.

    Raises:
        FileError: no such file, not a session, or one of a newer schema.
    """
    inside = contents(Path(path))
    _check_schema(Path(path), inside.metadata)
    events = {cls.__name__: inside.topics.get(topic_of(cls), ("", 0))[1] for cls in _KINDS}
    return SessionSummary(
        complete=events["SessionFinished"] > 0 and not inside.damage,
        trials=events["TrialFinished"],
        events=events,
        seconds=inside.end / 1e9,
        version=inside.metadata[METADATA].get("imitate", "unknown"),
        damage=inside.damage,
    )


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

    def events(self, steps: bool = True) -> Iterator[Event]:
        """The events as they were written, arrays equal bit for bit; of a cut file all that were flushed.

        Args:
            steps: False leaves every trial's record None, which is much faster.
        """
        kinds = {topic_of(cls): cls for cls in (*_KINDS, *((TrialSteps,) if steps else ()))}
        recorded: TrialSteps | None = None
        checked = False
        for message in self._file.messages(kinds):
            if not checked:  # the metadata comes before the first message
                _check_schema(self.path, self._file.metadata)
                checked = True
            event = self._decoded(message, kinds[message.topic])
            if isinstance(event, TrialSteps):
                recorded = event
                continue
            if isinstance(event, TrialFinished) and recorded is not None:
                event, recorded = self._with_record(event, recorded), None
            yield event
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
