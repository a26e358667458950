"""Any topic of an MCAP file as rows of plain values, one a message, its nested fields by dotted names.

Protocol Buffers, ROS 2 and JSON messages are decoded by the schemas that the file carries. Bytes (pictures,
point clouds, packed steps) are not plain values and are left out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import DecodeError, Message

from imitate.errors import FileError, UnknownNameError
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.messages import message_class
from imitate.formats.ros2 import Ros2Decoder

Row = dict[str, Any]
"""dotted name → number, string or truth value."""


def rows(path: Path | str, topic: str, damage: list[str] | None = None) -> Iterator[Row]:
    """The messages of a topic, each with its "log_time" in nanoseconds.

    Args:
        path: any MCAP file.
        topic: one of its topics.
        damage: gets what could not be read, in words.

    Raises:
        UnknownNameError: no such topic; lists those that there are.
        FileError: no MCAP file, or messages that cannot be decoded.
    """
    path = Path(path)
    topics = contents(path).topics
    if topic not in topics:
        raise UnknownNameError(f"topic of {path}:", topic, topics)
    reader, decoder = McapReader(path), _Decoder(path)
    for message in reader.messages({topic}):
        yield {"log_time": message.time} | flat(decoder.plain(message))
    if damage is not None:
        damage += reader.damage


def flat(value: Any, name: str = "") -> Row:
    """Nested mappings and lists as one mapping: {"a": [1, {"b": 2}]} is {"a.0": 1, "a.1.b": 2}."""
    if isinstance(value, Mapping):
        parts = value.items()
    elif isinstance(value, list | tuple):
        parts = {str(k): item for k, item in enumerate(value)}.items()
    else:
        return {name or "value": value}
    found: Row = {}
    for key, part in parts:
        found |= flat(part, f"{name}.{key}" if name else str(key))
    return found


class _Decoder:
    def __init__(self, path: Path) -> None:
        self._path = path
        self._types: dict[bytes, type[Message]] = {}
        self._ros = Ros2Decoder()

    def plain(self, message: RawMessage) -> Any:
        try:
            if message.encoding == "protobuf":
                return _of_protobuf(self._type(message).FromString(message.data))
            if message.encoding == "json":
                return json.loads(message.data)
        except (DecodeError, ValueError, RecursionError) as error:
            raise self._refused(message, f"cannot be read ({error})", "The file is damaged.") from None
        found = self._ros.decode(message) if message.encoding == "cdr" else None
        if found is None:
            encoding = f"{message.encoding or 'nothing'} by {message.schema_encoding or 'no schema'}"
            problem = f"is encoded as {encoding}, which could not be decoded"
            raise self._refused(message, problem, "Protocol Buffers, ROS 2 and JSON are.")
        return _of_ros(found)

    def _type(self, message: RawMessage) -> type[Message]:
        if message.schema not in self._types:
            self._types[message.schema] = message_class(message.schema_name, message.schema)
        return self._types[message.schema]

    def _refused(self, message: RawMessage, problem: str, remedy: str) -> FileError:
        return FileError(self._path, f"topic {message.topic} {problem}", remedy)


def _of_protobuf(message: Any) -> Row:
    found: Row = {}
    for field in message.DESCRIPTOR.fields:
        if field.type == FieldDescriptor.TYPE_BYTES:
            continue
        part = getattr(message, field.name)
        if field.message_type is not None and field.message_type.GetOptions().map_entry:
            found[field.name] = {str(key): _one(value) for key, value in sorted(part.items())}
        elif field.is_repeated:
            found[field.name] = [_one(item) for item in part]
        elif field.has_presence and not message.HasField(field.name):
            found[field.name] = {}  # not there: no column, or an empty cell of it
        else:
            found[field.name] = _one(part)
    return found


def _one(part: Any) -> Any:
    return _of_protobuf(part) if isinstance(part, Message) else part


def _of_ros(value: Any) -> Any:
    if isinstance(value, bytes | bytearray | memoryview):
        return {}
    if isinstance(value, list | tuple):
        return [_of_ros(item) for item in value]
    if isinstance(value, bool | int | float | str):
        return value
    return {name: _of_ros(getattr(value, name)) for name in value.__slots__}
