"""A writer of MCAP files that flushes, its channels and schemas in a fixed order."""

from __future__ import annotations

import struct
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Protocol

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import Message as ProtobufMessage
from mcap.writer import CompressionType, Writer

from imitate.formats.mcap_file import MAGIC

ENDING = b"\x0f" + struct.pack("<QI", 4, 0) + b"\x02" + struct.pack("<QQQI", 20, 0, 0, 0) + MAGIC
"""records DataEnd and Footer and the magic bytes: the end of a valid file without a summary."""
_MEDIA = {".toml": "application/toml", ".json": "application/json", ".urdf": "application/xml"}
"""suffix of an attachment → its media type."""


@dataclass(frozen=True)
class Channel:
    """A topic to be written, with everything that a reader needs to decode it."""

    topic: str
    encoding: str
    schema_name: str
    schema_encoding: str
    schema: bytes


def protobuf_channel(topic: str, message: type[ProtobufMessage]) -> Channel:
    """A channel of Protocol Buffers messages; the schema holds the message's file and all that it imports."""
    found: dict[str, Any] = {}
    _collect(message.DESCRIPTOR.file, found)
    described = FileDescriptorSet()
    for file in found.values():
        file.CopyToProto(described.file.add())
    return Channel(
        topic,
        "protobuf",
        message.DESCRIPTOR.full_name,
        "protobuf",
        described.SerializeToString(deterministic=True),
    )


def _collect(file: Any, found: dict[str, Any]) -> None:
    for imported in file.dependencies:
        _collect(imported, found)
    found[file.name] = file


class Sink(Protocol):
    """Where a file is written."""

    def write(self, data: bytes, /) -> object: ...

    def tell(self) -> int: ...

    def flush(self) -> object: ...


class McapWriter:
    """Writes one new file, its schemas and channels in the given order.

    Args:
        stream: an empty file, open for writing bytes; closing it is the caller's.
        channels: every topic that will be written.
        metadata: name → key → value.
    """

    def __init__(
        self,
        stream: Sink,
        channels: Sequence[Channel],
        metadata: Mapping[str, Mapping[str, str]] | None = None,
        chunk_size: int = 1 << 20,
    ) -> None:
        self._writer: Any = Writer(
            typing.cast(IO[bytes], stream), compression=CompressionType.ZSTD, chunk_size=chunk_size
        )
        self._writer.start(library="imitate")
        for name, values in (metadata or {}).items():
            self._writer.add_metadata(name, dict(values))
        schemas: dict[tuple[str, bytes], int] = {}
        self._channels: dict[str, int] = {}
        for channel in channels:
            key = (channel.schema_name, channel.schema)
            if key not in schemas:
                schemas[key] = self._writer.register_schema(
                    channel.schema_name, channel.schema_encoding, channel.schema
                )
            self._channels[channel.topic] = self._writer.register_channel(
                channel.topic, channel.encoding, schemas[key]
            )

    def write(self, topic: str, data: ProtobufMessage | bytes, time: int) -> None:
        """One message at ``time`` nanoseconds."""
        if not isinstance(data, bytes):
            data = data.SerializeToString(deterministic=True)
        self._writer.add_message(self._channels[topic], time, data, time)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """One metadata record, at this place of the file."""
        self._writer.add_metadata(name, dict(values))

    def attach(self, name: str, data: bytes) -> None:
        """One attachment, at this place of the file; of no time, so that equal sessions are equal files."""
        self._writer.add_attachment(0, 0, name, _MEDIA.get(Path(name).suffix, "text/plain"), data)

    def flush(self) -> None:
        """Everything so far is in the file after this, should the process die."""
        self._writer.flush()

    def finish(self) -> None:
        """The summary and the end; nothing can be written after it."""
        self._writer.finish()

    def __enter__(self) -> McapWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.finish()
