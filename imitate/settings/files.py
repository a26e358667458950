"""Settings from a mode, a TOML file and words of one's own; and back to TOML."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from imitate.errors import FileError, UnknownNameError, UsageError
from imitate.settings.modes import OF_MODE, Settings
from imitate.text_file import read_text


def load_settings(path: Path | None = None, overrides: dict[str, Any] | None = None) -> Settings:
    """Settings of a mode, changed by a TOML file and then by ``overrides`` (nested, as in the file).

    Raises:
        FileError: the file is missing or is not TOML.
        UsageError: an unknown setting or a value out of range; the message lists what is valid.
    """
    given: dict[str, Any] = {}
    if path is not None:
        given = _read_toml(path)
    given = _merge(given, overrides or {})
    base = OF_MODE.get(str(given.get("mode")), {})
    return parse_settings(_merge(base, given), str(path or "settings"))


def parse_settings(values: dict[str, Any], where: str = "settings") -> Settings:
    """Settings from nested plain values; errors as in `load_settings`."""
    try:
        return Settings.model_validate(values)
    except ValidationError as error:
        raise _readable(error, where) from None


def settings_from_toml(text: str) -> Settings:
    """The inverse of `to_toml`, also for the settings that a session of an earlier version recorded.

    What there is no setting for any more is left out, and what there was none for yet has its default: a
    session holds all that its physics follows from.
    """
    values = tomllib.loads(text)
    try:
        return Settings.model_validate(values)
    except ValidationError as error:
        gone = [e["loc"] for e in error.errors() if e["type"] == "extra_forbidden"]
    for *sections, name in gone:
        inner = values
        for section in sections:
            inner = inner[str(section)]
        del inner[str(name)]
    return parse_settings(values)


def to_toml(settings: Settings) -> str:
    """All settings as TOML, defaults included."""
    top, tables = [], []
    for name, value in settings.model_dump().items():
        if isinstance(value, dict):
            tables.append(f"\n[{name}]\n" + "".join(f"{k} = {_toml(v)}\n" for k, v in value.items()))
        else:
            top.append(f"{name} = {_toml(value)}\n")
    return "".join(top) + "".join(tables)


def dotted(table: Mapping[str, Any]) -> dict[str, Any]:
    """A TOML table's values by their dotted names: `[learn]` and `stop = "S"` is {"learn.stop": "S"}."""
    found: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, dict):
            found |= {f"{name}.{k}": v for k, v in dotted(value).items()}
        else:
            found[name] = value
    return found


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return repr(value)


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(read_text(path))
    except FileNotFoundError:
        raise FileError(path, "no such settings file", "Pass a TOML file to --settings.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})") from None
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not TOML ({error})") from None


def _merge(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in over.items():
        inner = merged.get(key)
        merged[key] = _merge(inner, value) if isinstance(inner, dict) and isinstance(value, dict) else value
    return merged


def _readable(error: ValidationError, where: str) -> UsageError:
    first = error.errors()[0]
    path = [str(part) for part in first["loc"]]
    if first["type"] == "extra_forbidden":
        model: type[BaseModel] = Settings
        for part in path[:-1]:
            model = type(model.model_fields[part].default)
        section = f" [{'.'.join(path[:-1])}]" if path[1:] else ""
        return UnknownNameError(f"setting in {where}{section}:", path[-1], model.model_fields)
    if not path:  # of several settings together
        return UsageError(f"{where}: {first['msg'].removeprefix('Value error, ')}.")
    return UsageError(f"{where}: {'.'.join(path)} = {first['input']!r}: {first['msg'].lower()}.")
