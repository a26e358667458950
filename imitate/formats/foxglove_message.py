"""Foxglove's messages in the two of their encodings that are read: Protocol Buffers and JSON."""

from __future__ import annotations

import json
from typing import Any, TypeVar

from google.protobuf.json_format import ParseDict, ParseError
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp

from imitate.formats.mcap_file import RawMessage

M = TypeVar("M", bound=Message)


def foxglove_message(kind: type[M], message: RawMessage) -> M:
    """A message as the class of its schema.

    Raises:
        DecodeError, ValueError: it is none.
    """
    if message.encoding != "json":
        return kind.FromString(message.data)
    fields = json.loads(message.data, object_hook=_timed)
    if not isinstance(fields, dict):
        raise ValueError("it has no fields")
    try:
        return ParseDict(fields, kind(), ignore_unknown_fields=True)
    except ParseError as error:
        raise ValueError(str(error)) from None


def _timed(fields: dict[str, Any]) -> Any:
    # Foxglove's JSON has a time as two numbers, that of Protocol Buffers as a text.
    if fields.keys() != {"sec", "nsec"}:
        return fields
    try:
        return Timestamp(seconds=fields["sec"], nanos=fields["nsec"]).ToJsonString()
    except TypeError as error:
        raise ValueError(str(error)) from None
