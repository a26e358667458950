"""What is inside an MCAP file, from its summary where that is sound: a large file in a moment."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import SeekingReader

from imitate.formats.mcap_file import DAMAGE, McapReader, check_magic


@dataclass(frozen=True)
class Contents:
    """What is inside an MCAP file.

    Attributes:
        topics: topic → (schema name, number of messages).
        metadata: name → key → value.
        attachments: names.
        start, end: nanoseconds, first and last log time; 0 without messages.
        damage: what is wrong with the file, in words; empty when it is whole.
    """

    topics: Mapping[str, tuple[str, int]]
    metadata: Mapping[str, Mapping[str, str]]
    attachments: tuple[str, ...]
    start: int
    end: int
    damage: tuple[str, ...]


def contents(path: Path, thorough: bool = False) -> Contents:
    """What is inside: from the file's summary where it has a sound one, else by reading all of it.

    Args:
        path: the file.
        thorough: read all of it in any case, so that a damaged chunk in the middle is found.

    Raises:
        FileError: no such file, or not an MCAP file.
    """
    path = Path(path)
    check_magic(path)
    if thorough:
        return _scanned_contents(path)
    try:
        return _indexed_contents(path)
    except (*DAMAGE, OSError, StopIteration):
        return _scanned_contents(path)


def _indexed_contents(path: Path) -> Contents:
    with path.open("rb") as stream:
        reader = SeekingReader(stream, record_size_limit=path.stat().st_size)
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise McapError("no summary")
        statistics = summary.statistics
        if statistics.metadata_count != len(summary.metadata_indexes):
            raise McapError("no index of the metadata")
        if statistics.attachment_count != len(summary.attachment_indexes):
            raise McapError("no index of the attachments")
        if statistics.channel_count != len(summary.channels):
            raise McapError("no copy of the channels")
        counts: dict[str, tuple[str, int]] = {}
        for key, channel in summary.channels.items():
            name = summary.schemas[channel.schema_id].name if channel.schema_id else ""
            before = counts.get(channel.topic, (name, 0))[1]
            counts[channel.topic] = (name, before + statistics.channel_message_counts.get(key, 0))
        return Contents(
            topics=counts,
            metadata={record.name: dict(record.metadata) for record in reader.iter_metadata()},
            attachments=tuple(index.name for index in summary.attachment_indexes),
            start=statistics.message_start_time,
            end=statistics.message_end_time,
            damage=(),
        )


def _scanned_contents(path: Path) -> Contents:
    reader = McapReader(path)
    counts: Counter[str] = Counter()
    schemas: dict[str, str] = {}
    times = []
    for message in reader.messages():
        counts[message.topic] += 1
        schemas[message.topic] = message.schema_name
        times.append(message.time)
    return Contents(
        topics={topic: (schemas[topic], count) for topic, count in counts.items()},
        metadata=reader.metadata,
        attachments=tuple(reader.attachments),
        start=min(times, default=0),
        end=max(times, default=0),
        damage=tuple(reader.damage),
    )
