"""MCAP files: a reader that survives foreign and damaged ones.

The reader goes through a file from front to back, as mcap's NonSeekingReader does, because mcap's default
reader follows an index that valid files need not have and that cut files do not have.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import zstandard
from mcap import records
from mcap.exceptions import EndOfFile, McapError, RecordLengthLimitExceeded
from mcap.reader import SeekingReader
from mcap.stream_reader import StreamReader, breakup_chunk

from imitate.errors import FileError

MAGIC = b"\x89MCAP0\r\n"
FROM_ROS1 = "ROS 1 is not read; rosbags-convert, of the package rosbags, makes a ROS 2 bag of it, in MCAP."
_CONVERT = {
    b"SQLite f": "A ROS 2 bag in SQLite becomes MCAP with `mcap convert FILE.db3 FILE.mcap`.",
    b"#ROSBAG ": FROM_ROS1,
}
"""first bytes → what to do."""
LARGEST_CHUNK = 1 << 30
"""bytes of an uncompressed chunk beyond which a file is taken as damaged rather than believed."""

DAMAGE = (
    McapError,
    struct.error,
    zstandard.ZstdError,
    KeyError,
    ValueError,
    RuntimeError,
    OverflowError,
    MemoryError,
)
"""beside its own errors mcap raises these on damaged input: lz4 a RuntimeError, bad UTF-8 a ValueError."""


@dataclass(frozen=True)
class RawMessage:
    """One message, not decoded.

    Attributes:
        topic: the channel's.
        encoding: of the data: "protobuf", "cdr", "json", …
        schema_name, schema_encoding, schema: empty where the channel has no schema.
        time: the log time in nanoseconds.
        data: the message.
    """

    topic: str
    encoding: str
    schema_name: str
    schema_encoding: str
    schema: bytes
    time: int
    data: bytes


@dataclass
class McapReader:
    """Reads one file; ``metadata``, ``attachments`` and ``damage`` fill while `messages` runs.

    Raises:
        FileError: on construction, when there is no such file or it is not an MCAP file.
    """

    path: Path
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    damage: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.path = Path(self.path)
        check_magic(self.path)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[RawMessage]:
        """Every whole message in the order of the file, of ``topics`` or of all.

        What cannot be read is left out and described in ``damage``: a chunk whose checksum or compression
        is wrong, or everything from the point where the file is cut.
        """
        schemas, channels, chunks, counts = _described(self.path)
        found: Counter[int] = Counter()
        wanted = {key for key, channel in channels.items() if topics is None or channel.topic in topics}
        skipped = {at for at, held in chunks.items() if held and held <= channels.keys() - wanted}
        with self.path.open("rb") as stream:
            for record in self._records(stream, skipped, set(chunks)):
                if isinstance(record, records.Schema):
                    schemas[record.id] = record
                elif isinstance(record, records.Channel):
                    channels[record.id] = record
                elif isinstance(record, records.Metadata):
                    self.metadata[record.name] = dict(record.metadata)
                elif isinstance(record, records.Attachment):
                    self.attachments[record.name] = record.data
                elif isinstance(record, records.Message):
                    channel = channels.get(record.channel_id)
                    if channel is None:
                        self._note(f"messages on channel {record.channel_id}, which it does not describe")
                    elif topics is None or channel.topic in topics:
                        found[channel.id] += 1
                        yield _raw(record, channel, schemas.get(channel.schema_id))
        for key in wanted if counts and not self.damage else ():
            if found[key] != counts.get(key, 0):  # another kind of record was taken for a message, say
                topic = channels[key].topic
                self._note(f"{found[key]} messages of {topic}, where its summary counts {counts.get(key, 0)}")

    def _records(self, stream: IO[bytes], skipped: Collection[int], indexed: set[int]) -> Iterator[Any]:
        # by the file's index: ``indexed`` are the ends of chunks, ``skipped`` of those with nothing asked for
        size = self.path.stat().st_size
        reader = StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size)
        found = reader.records
        while True:
            try:
                record = next(found)
                if isinstance(record, records.Chunk):
                    indexed.discard(stream.tell())
                if not (isinstance(record, records.Chunk) and stream.tell() in skipped):
                    yield from self._unpacked(record, stream.tell())
            except StopIteration:
                for at in sorted(indexed):  # a record whose kind was changed is passed over, not refused
                    self._note(f"no chunk that ends at byte {at:,}, where its index has one")
                return
            except DAMAGE as error:
                # a record longer than the file is the usual sight of a file that was cut inside a chunk
                if stream.tell() >= size or isinstance(error, EndOfFile | RecordLengthLimitExceeded):
                    self._note(f"cut at byte {size:,}: the end of the file is missing")
                else:
                    self._note(f"unreadable from about byte {stream.tell():,} ({_words(error)})")
                return

    def _unpacked(self, record: Any, at: int) -> Sequence[Any]:
        if not isinstance(record, records.Chunk):
            return (record,)
        try:
            _check_chunk_size(record)
            return breakup_chunk(record, validate_crc=True)
        except DAMAGE as error:
            self._note(f"a damaged chunk that ends at byte {at:,} ({_words(error)})")
            return ()

    def _note(self, damage: str) -> None:
        if damage not in self.damage:
            self.damage.append(damage)


def check_magic(path: Path) -> None:
    """Raises FileError unless ``path`` is a file that starts like an MCAP file."""
    if path.is_dir():
        raise FileError(path, "is a folder, not an MCAP file", "Name the .mcap file inside it.")
    try:
        with path.open("rb") as stream:
            start = stream.read(len(MAGIC))
    except FileNotFoundError:
        raise FileError(path, "no such file") from None
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from None
    if not start:
        raise FileError(path, "is empty", "Record it again.")
    if start.startswith(b"PK"):
        raise FileError(
            path,
            "is an NPZ archive, not an MCAP file",
            f"An NPZ holds a demonstration: imitate learn {path}",
        )
    if start != MAGIC:
        raise FileError(
            path,
            f"is not an MCAP file: it starts with {start!r}",
            _CONVERT.get(start) or "Give a recording, a demonstration or a session in MCAP format.",
        )


def _described(
    path: Path,
) -> tuple[dict[int, records.Schema], dict[int, records.Channel], dict[int, set[int]], dict[int, int]]:
    """What the end of a whole file repeats: schemas, channels, the channels in the chunk of each end, and how
    many messages each channel has.

    With it a damaged first chunk costs no more than its messages, and a chunk may be passed over.
    """
    try:
        with path.open("rb") as stream:
            summary = SeekingReader(stream, record_size_limit=path.stat().st_size).get_summary()
    except (*DAMAGE, OSError, StopIteration):
        summary = None
    if summary is None:
        return {}, {}, {}, {}
    chunks = {
        c.chunk_start_offset + c.chunk_length: set(c.message_index_offsets) for c in summary.chunk_indexes
    }
    counts = dict(summary.statistics.channel_message_counts) if summary.statistics else {}
    return dict(summary.schemas), dict(summary.channels), chunks, counts


def _raw(message: records.Message, channel: records.Channel, schema: records.Schema | None) -> RawMessage:
    return RawMessage(
        topic=channel.topic,
        encoding=channel.message_encoding,
        schema_name=schema.name if schema else "",
        schema_encoding=schema.encoding if schema else "",
        schema=schema.data if schema else b"",
        time=message.log_time,
        data=message.data,
    )


def _check_chunk_size(chunk: records.Chunk) -> None:
    sizes = [chunk.uncompressed_size]
    if chunk.compression == "zstd":
        sizes.append(zstandard.get_frame_parameters(chunk.data).content_size)
    # an unknown size is written as one of the largest two 64-bit numbers
    if any(LARGEST_CHUNK < size < 2**64 - 2 for size in sizes):
        raise ValueError(f"it claims {max(sizes):,} bytes")


def _words(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
