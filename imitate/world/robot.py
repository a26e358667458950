"""An arm with a parallel gripper, described by data, not by subclass."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from imitate.errors import FileError, UnknownNameError

_SHIPPED = Path(__file__).parent / "robots"


@dataclass(frozen=True)
class Robot:
    """What the simulation needs to know of an arm.

    Attributes:
        urdf: path, absolute, beside the description, or within pybullet_data.
        hand_link: link that carries the fingers.
        tcp: pose of the tool-centre point in that link's frame: y along the fingers' opening, z outwards.
        arm, fingers: joint names.
        rest: arm joint positions (rad) from which inverse kinematics starts.
        finger_open, finger_closed: position of each finger joint (m).
        finger_speed: m/s.
        finger_friction: lateral friction coefficient of the fingers.
        opening_force, closing_force_limit: N.
        base_distance: distances (m) of the base from the workspace's centre, in order of preference.
        reach: m from the base that the hand gets to at most.
    """

    urdf: str
    hand_link: str
    tcp: tuple[float, ...]
    arm: tuple[str, ...]
    rest: tuple[float, ...]
    fingers: tuple[str, ...]
    finger_open: float
    finger_closed: float
    finger_speed: float
    finger_friction: float
    opening_force: float
    closing_force_limit: float
    base_distance: tuple[float, ...]
    reach: float


_KINDS = {
    "str": "text",
    "float": "a number",
    "tuple[str, ...]": "a list of names",
    "tuple[float, ...]": "a list of numbers",
}


def load_robot(name: str) -> Robot:
    """A robot shipped with imitate, by name, or described by a TOML file, by path.

    Raises:
        UnknownNameError: no such shipped robot.
        FileError: the file is missing, is no TOML, or lacks a field or has a wrong one.
    """
    shipped = {path.stem: path for path in _SHIPPED.glob("*.toml")}
    path = Path(name) if name.endswith(".toml") else shipped.get(name)
    if path is None:
        raise UnknownNameError("robot", name, shipped)
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise FileError(path, "no such robot description") from None
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not TOML ({error})") from None
    needed = {field.name for field in fields(Robot)}
    if missing := sorted(needed - values.keys()):
        raise FileError(path, f"lacks {', '.join(missing)}", f"A robot has {', '.join(sorted(needed))}.")
    if unknown := sorted(values.keys() - needed):
        raise FileError(
            path, f"has unknown {', '.join(unknown)}", f"A robot has {', '.join(sorted(needed))}."
        )
    for field in fields(Robot):
        if not _fits(values[field.name], str(field.type)):
            raise FileError(
                path, f"{field.name} = {values[field.name]!r}", f"Expected {_KINDS[str(field.type)]}."
            )
    if len(values["tcp"]) != 7 or len(values["rest"]) != len(values["arm"]):
        raise FileError(path, "tcp has 7 numbers, and rest one for each joint of arm; these have not")
    beside = path.parent / values["urdf"]
    if beside.exists():
        values["urdf"] = str(beside.resolve())
    read: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in values.items()}
    return Robot(**read)


def _fits(value: Any, kind: str) -> bool:
    if kind.startswith("tuple"):
        inner = kind.removeprefix("tuple[").removesuffix(", ...]")
        return isinstance(value, list) and len(value) > 0 and all(_fits(item, inner) for item in value)
    if kind == "str":
        return isinstance(value, str)
    return isinstance(value, int | float) and not isinstance(value, bool)
