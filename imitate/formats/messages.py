"""Frozen dataclasses ⇄ Protocol Buffers messages, by the types of their fields.

The dataclass is the one description of what is stored: `describe` derives a protobuf schema from it. Reading
goes by the *names* in the schema that the file carries, so that fields may be added and moved later: a field
that an older file lacks gets its default, or None where it may be None.

    str, Literal of str → string        int → int64       float → double     bool → bool    bytes → bytes
    tuple[X, ...] → repeated X          Mapping[str, str] → map<string, string>
    an array → Array {repeated int64 shape; repeated double values}            another dataclass → its message
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypeVar

import numpy as np
from google.protobuf import message_factory
from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import Message

from imitate.geometry import read_only

PACKAGE = "imitate"
T = TypeVar("T")
_SCALARS: dict[type, Any] = {
    str: FieldDescriptorProto.TYPE_STRING,
    int: FieldDescriptorProto.TYPE_INT64,
    float: FieldDescriptorProto.TYPE_DOUBLE,
    bool: FieldDescriptorProto.TYPE_BOOL,
    bytes: FieldDescriptorProto.TYPE_BYTES,
}


@dataclass(frozen=True)
class _Field:
    """How one field of a dataclass is stored.

    Attributes:
        kind: what it is made of.
        inner: the scalar or the dataclass, where ``kind`` has one.
        default: the value for a file that lacks it; MISSING when there is none.
    """

    name: str
    kind: Literal["scalar", "message", "scalars", "messages", "map", "array"]
    inner: Any
    default: Any


def describe(
    classes: Iterable[type], omit: frozenset[tuple[type, str]] = frozenset()
) -> dict[type, type[Message]]:
    """A message class for each dataclass and for every dataclass inside it.

    Args:
        classes: dataclasses with distinct names.
        omit: (dataclass, field) pairs that are not stored.
    """
    file = FileDescriptorProto(name="imitate/session.proto", package=PACKAGE, syntax="proto3")
    array = file.message_type.add(name="Array")
    _add(array, "shape", 1, FieldDescriptorProto.TYPE_INT64, repeated=True)
    _add(array, "values", 2, FieldDescriptorProto.TYPE_DOUBLE, repeated=True)
    seen: dict[type, None] = {}
    for cls in classes:
        _visit(cls, seen, omit)
    for cls in seen:
        _describe_one(file.message_type.add(name=cls.__name__), cls, omit)
    pool = DescriptorPool()
    pool.Add(file)
    return {cls: _class(pool, f"{PACKAGE}.{cls.__name__}") for cls in seen}


def message_class(name: str, schema: bytes) -> type[Message]:
    """The class of messages called ``name`` in a serialised FileDescriptorSet.

    Raises:
        ValueError: the schema is damaged or does not describe ``name``.
    """
    try:
        pool = DescriptorPool()
        for file in FileDescriptorSet.FromString(schema).file:
            pool.Add(file)
        return _class(pool, name)
    except Exception as error:  # protobuf raises its own kinds, TypeError and KeyError
        raise ValueError(f"no usable schema of {name} ({error})") from None


def encode(value: Any, described: Mapping[type, type[Message]]) -> Message:
    """A dataclass instance as the message that `describe` derived for it."""
    message = described[type(value)]()
    _fill(message, value)
    return message


def decode(cls: type[T], message: Any) -> T:
    """The inverse of `encode`, from a message of any schema that has the dataclass's fields by name.

    Raises:
        ValueError: a field is missing that has no default.
    """
    known = message.DESCRIPTOR.fields_by_name
    values = {}
    for field in _fields(cls):
        if field.name in known:
            values[field.name] = _value(field, message)
        elif field.default is dataclasses.MISSING:
            raise ValueError(f"{cls.__name__} has no field {field.name!r}")
        else:
            values[field.name] = field.default
    return cls(**values)


def _class(pool: DescriptorPool, name: str) -> type[Message]:
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(name))


def _visit(cls: type, seen: dict[type, None], omit: frozenset[tuple[type, str]]) -> None:
    if cls in seen:
        return
    seen[cls] = None
    for field in _fields(cls):
        if field.kind in ("message", "messages") and (cls, field.name) not in omit:
            _visit(field.inner, seen, omit)


def _describe_one(message: DescriptorProto, cls: type, omit: frozenset[tuple[type, str]]) -> None:
    for number, field in enumerate(_fields(cls), start=1):
        if (cls, field.name) in omit:
            continue
        repeated = field.kind in ("scalars", "messages", "map")
        if field.kind in ("scalar", "scalars"):
            _add(message, field.name, number, _SCALARS[field.inner], repeated)
            if field.default is None:  # a scalar tells none from zero only as a oneof's single member
                message.field[-1].proto3_optional = True
                message.field[-1].oneof_index = len(message.oneof_decl)
                message.oneof_decl.add(name=f"_{field.name}")
        elif field.kind == "map":
            entry = message.nested_type.add(name="".join(map(str.title, field.name.split("_"))) + "Entry")
            entry.options.map_entry = True
            _add(entry, "key", 1, FieldDescriptorProto.TYPE_STRING)
            _add(entry, "value", 2, FieldDescriptorProto.TYPE_STRING)
            _add(message, field.name, number, f"{cls.__name__}.{entry.name}", repeated)
        else:
            _add(
                message,
                field.name,
                number,
                "Array" if field.kind == "array" else field.inner.__name__,
                repeated,
            )


def _add(message: DescriptorProto, name: str, number: int, kind: Any, repeated: bool = False) -> None:
    label = FieldDescriptorProto.LABEL_REPEATED if repeated else FieldDescriptorProto.LABEL_OPTIONAL
    field = message.field.add(name=name, number=number, label=label)
    if isinstance(kind, str):
        field.type = FieldDescriptorProto.TYPE_MESSAGE
        field.type_name = f".{PACKAGE}.{kind}"
    else:
        field.type = kind


def _fields(cls: Any) -> tuple[_Field, ...]:
    return _cached_fields(cls)


@cache
def _cached_fields(cls: Any) -> tuple[_Field, ...]:
    hints = typing.get_type_hints(cls)
    return tuple(_field(field, hints[field.name]) for field in dataclasses.fields(cls))


def _field(field: dataclasses.Field[Any], hint: Any) -> _Field:
    default = field.default
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType) and type(None) in arguments:
        default = None if default is dataclasses.MISSING else default
        (hint,) = (argument for argument in arguments if argument is not type(None))
        origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is tuple:
        inner = _plain(arguments[0])
        return _Field(
            field.name, "messages" if dataclasses.is_dataclass(inner) else "scalars", inner, default
        )
    if origin is np.ndarray:
        return _Field(field.name, "array", None, default)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _Field(field.name, "map", None, default)
    inner = _plain(hint)
    if dataclasses.is_dataclass(inner):
        return _Field(field.name, "message", inner, default)
    if inner not in _SCALARS:
        raise TypeError(f"{field.name}: no message for {hint}")
    return _Field(field.name, "scalar", inner, default)


def _plain(hint: Any) -> Any:
    return type(typing.get_args(hint)[0]) if typing.get_origin(hint) is Literal else hint


def _fill(message: Any, value: Any) -> None:
    known = message.DESCRIPTOR.fields_by_name
    for field in _fields(type(value)):
        part = getattr(value, field.name)
        if field.name not in known or part is None:
            continue
        if field.kind == "scalar":
            setattr(message, field.name, part)
        elif field.kind == "message":
            target = getattr(message, field.name)
            target.SetInParent()
            _fill(target, part)
        elif field.kind == "array":
            target = getattr(message, field.name)
            target.shape.extend(part.shape)
            target.values.extend(part.ravel().tolist())
        elif field.kind == "messages":
            for item in part:
                _fill(getattr(message, field.name).add(), item)
        elif field.kind == "map":
            getattr(message, field.name).update(part)
        else:
            getattr(message, field.name).extend(part)


def _value(field: _Field, message: Any) -> Any:
    part = getattr(message, field.name)
    if field.kind == "scalar":
        return None if field.default is None and not message.HasField(field.name) else part
    if field.kind == "message":
        absent = field.default is None and not message.HasField(field.name)
        return None if absent else decode(field.inner, part)
    if field.kind == "array":
        if field.default is None and not message.HasField(field.name):
            return None
        return read_only(np.array(part.values, dtype=np.float64).reshape(tuple(part.shape)))
    if field.kind == "messages":
        return tuple(decode(field.inner, item) for item in part)
    return dict(part) if field.kind == "map" else tuple(part)
