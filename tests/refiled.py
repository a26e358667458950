"""Sessions' files compared, cut, and written again with something changed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from imitate.events import Event, SessionStarted
from imitate.formats.mcap_file import McapReader
from imitate.formats.mcap_writer import McapWriter
from imitate.formats.session_log import read_session
from imitate.formats.session_messages import channels_of
from imitate.formats.session_writer import SessionWriter


def messages(path: Path) -> list[tuple[str, int, bytes]]:
    """Everything in a file, as it is there."""
    return [(m.topic, m.time, m.data) for m in McapReader(path).messages()]


def written(path: Path, events: Iterable[Event], steps: bool = True) -> Path:
    with SessionWriter(path, steps=steps) as log:
        for event in events:
            log.write(event)
    return path


def cut(session: Path, path: Path, share: float) -> Path:
    """The first part of a session's file."""
    data = session.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    return path


def flipped(session: Path, path: Path, topic: str, number: int) -> Path:
    """A session with the last bit of one message of a topic changed."""
    reader, started = McapReader(session), next(read_session(session))
    assert isinstance(started, SessionStarted)
    found, seen = list(reader.messages()), 0
    with path.open("wb") as stream, McapWriter(stream, channels_of(started), reader.metadata) as log:
        for message in found:
            data = bytearray(message.data)
            if message.topic == topic:
                data[-1] ^= seen == number
                seen += 1
            log.write(message.topic, bytes(data), message.time)
    return path
