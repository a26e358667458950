"""Every constant of the method, typed, with unit and source; TOML in and out.

Two complete sets exist: ``robust`` (the default, for users) and ``faithful`` (as the paper states it, for the
tables). A settings file holds ``mode`` and whatever is to differ from that mode's values.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from imitate.errors import FileError, UnknownNameError, UsageError

Mode = Literal["robust", "faithful"]


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Perception(_Section):
    """RGB-D frames → demonstration (the paper, Appendix A)."""

    hand_offset: float = Field(0.0, ge=-0.5, le=0.5)
    """m along the hand's −z: 0.1 puts the origin where the paper has it; undone in the demonstration."""


class Segmentation(_Section):
    """Demonstration → segments (the paper, section 4)."""

    mode: Mode = "robust"


class PolicySettings(_Section):
    """How a movement is written down (the paper, section 5.2 and Appendix B)."""

    pose_kernels: int = Field(30, ge=2, le=500)
    gripper_kernels: int = Field(5, ge=2, le=100)


class Learning(_Section):
    """Trials, updates, evaluation, reformulation (the paper, sections 5 and 6; ALGORITHMS 4 and 5)."""

    alpha: float = Field(0.8, gt=0, le=1)
    """P(β=1|π) from which an option is accepted."""
    evaluation_starts: int = Field(20, ge=1)
    """perturbed starts over which P is estimated."""


class World(_Section):
    """The simulated robot and table."""

    robot: str = "panda"
    """name of a robot shipped with imitate, or the path of a robot's TOML file."""


class Settings(_Section):
    """All of them."""

    mode: Mode = "robust"
    perception: Perception = Perception()
    segmentation: Segmentation = Segmentation()
    policy: PolicySettings = PolicySettings()
    learning: Learning = Learning()
    world: World = World()


_FAITHFUL: dict[str, dict[str, Any]] = {
    "segmentation": {"mode": "faithful"},
}


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
    base = _FAITHFUL if given.get("mode") == "faithful" else {}
    return parse_settings(_merge(base, given), str(path or "settings"))


def parse_settings(values: dict[str, Any], where: str = "settings") -> Settings:
    """Settings from nested plain values; errors as in `load_settings`."""
    try:
        return Settings.model_validate(values)
    except ValidationError as error:
        raise _readable(error, where) from None


def settings_from_toml(text: str) -> Settings:
    """The inverse of `to_toml`."""
    return parse_settings(tomllib.loads(text))


def to_toml(settings: Settings) -> str:
    """All settings as TOML, defaults included."""
    top, tables = [], []
    for name, value in settings.model_dump().items():
        if isinstance(value, dict):
            tables.append(f"\n[{name}]\n" + "".join(f"{k} = {_toml(v)}\n" for k, v in value.items()))
        else:
            top.append(f"{name} = {_toml(value)}\n")
    return "".join(top) + "".join(tables)


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
        return tomllib.loads(path.read_text(encoding="utf-8"))
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
        return UnknownNameError(f"setting in {where}:", ".".join(path), model.model_fields)
    return UsageError(f"{where}: {'.'.join(path)} = {first['input']!r}: {first['msg'].lower()}.")
