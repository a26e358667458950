"""A clean, whole file of a session's cut or damaged one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import IO

from imitate.errors import FileError
from imitate.events import SessionFinished, SessionStarted, TrialFinished
from imitate.formats.growing import refuse_locked
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.mcap_writer import Channel, McapWriter
from imitate.formats.output import new_file, refuse_existing, require_mcap
from imitate.formats.session_log import SessionReader
from imitate.formats.session_messages import KINDS, topic_of
from imitate.formats.steps import TrialSteps


@dataclass(frozen=True)
class Recovered:
    """What there was in a session's file.

    Attributes:
        events, trials: how many were recovered.
        stepless: trials among them without steps.
        finished: whether the session had ended.
        lost: what could not be read, in words; empty where nothing is lost.
    """

    events: int
    trials: int
    stepless: int
    finished: bool
    lost: tuple[str, ...]


def recover(path: Path, output: Path, force: bool = False) -> Recovered:
    """Writes all whole events of ``path`` to ``output``, which is a whole file with an index.

    Raises:
        FileError: no session, one that is being written, one whose start is lost, or ``output`` exists.
    """
    require_mcap(output)
    refuse_existing(output, force)
    if path.is_file():
        refuse_locked(path)
    found = _what_is_there(path)
    with new_file(output, force) as temporary, temporary.open("wb") as stream:
        _copy(path, stream)
    return found


def _what_is_there(path: Path) -> Recovered:
    reader = SessionReader(path)
    events = trials = stepless = 0
    finished = False
    for event in reader.events():
        if not events and not isinstance(event, SessionStarted):
            why = "; ".join(reader.damage)
            raise FileError(path, f"its start is lost ({why})", "Nothing can be made of the rest.")
        events += 1
        finished |= isinstance(event, SessionFinished)
        if isinstance(event, TrialFinished):
            trials += 1
            stepless += event.record is None
    if not events:
        raise FileError(path, f"holds no whole event ({'; '.join(reader.damage)})", "Learn again.")
    return Recovered(events, trials, stepless, finished, tuple(reader.damage))


def _copy(path: Path, stream: IO[bytes]) -> None:
    # Messages as they are, each event with those before it; what belongs to no event any more is left out.
    channels: dict[str, Channel] = {}
    reader = McapReader(path)
    for m in reader.messages():
        channel = Channel(m.topic, m.encoding, m.schema_name, m.schema_encoding, m.schema)
        channels.setdefault(m.topic, channel)
    ends, steps = {topic_of(kind) for kind in KINDS}, topic_of(TrialSteps)
    waiting: list[RawMessage] = []
    with McapWriter(stream, list(channels.values()), reader.metadata, chunk_size=1 << 26) as log:
        for name, data in reader.attachments.items():
            log.attach(name, data)
        for message in McapReader(path).messages():
            waiting.append(message)
            if message.topic not in ends:
                continue
            for m in waiting:
                log.write(m.topic, m.data, m.time)
                if m.topic == steps:
                    log.flush()  # a chunk of its own, as the session's writer has it
            log.flush()
            waiting.clear()
