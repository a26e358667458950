"""An arm with a parallel gripper, described by data, not by subclass.

A description is a TOML file; the fields of `Robot` are its keys, and those with a default may be left out.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any

from imitate.errors import FileError, UnknownNameError
from imitate.record import SceneSpec
from imitate.text_file import read_text

_SHIPPED = Path(__file__).parent / "robots"


@dataclass(frozen=True)
class Robot:
    """What the simulation needs to know of an arm.

    A joint's unit is m where it slides and rad where it turns.

    Attributes:
        urdf: a URDF or an SDF file: absolute, beside the description, or within pybullet_data.
        hand_link: link that carries the fingers.
        tcp: pose of the tool-centre point in that link's frame: between the fingertips, y along the fingers'
            opening, z towards the fingertips.
        arm: joint names, from base to hand.
        rest: arm joint positions from which inverse kinematics starts.
        fingers: joints that the gripper's motor drives, one for each finger.
        finger_open, finger_closed: positions of those joints; one number stands for all.
        finger_speed: m/s of a fingertip.
        finger_friction: lateral friction coefficient of the fingers.
        opening_force, closing_force_limit: N at each fingertip.
        base_distance: distances (m) of the base from the workspace's centre, in order of preference.
        reach: m from the base that the hand gets to at most.
        finger_lever: m that a fingertip moves for one unit of its joint; 1 where it slides.
        followers: joint that a linkage moves with the fingers → its positions when open and when closed.
        held: joint that keeps still → its position; joints not named anywhere are held at 0.
        base_height: m of the base's origin above the table.
        base_bearing: directions (rad, about z from its x) in which the base may see the workspace's centre.
        base_clearance: m from the base's origin within which no object stands.
        solver_iterations: of the contact solver, at least: light fingers and linkages converge slowly.
    """

    urdf: str
    hand_link: str
    tcp: tuple[float, ...]
    arm: tuple[str, ...]
    rest: tuple[float, ...]
    fingers: tuple[str, ...]
    finger_open: tuple[float, ...]
    finger_closed: tuple[float, ...]
    finger_speed: float
    finger_friction: float
    opening_force: float
    closing_force_limit: float
    base_distance: tuple[float, ...]
    reach: float
    finger_lever: float = 1.0
    followers: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    base_height: float = 0.0
    base_bearing: tuple[float, ...] = (0.0,)
    base_clearance: float = 0.2
    solver_iterations: int = 0

    @property
    def closing_time(self) -> float:
        """Seconds that the fingers take from open to closed."""
        travel = max(abs(a - b) for a, b in zip(self.finger_open, self.finger_closed, strict=True))
        return travel * self.finger_lever / self.finger_speed


_PER_FINGER = ("finger_open", "finger_closed")
_KINDS = {
    "str": "text",
    "float": "a number",
    "int": "a whole number",
    "tuple[str, ...]": "a list of names",
    "tuple[float, ...]": "a list of numbers",
    "Mapping[str, float]": "a table of joint = position",
    "Mapping[str, tuple[float, ...]]": "a table of joint = [position when open, position when closed]",
}


def description_of(name: str) -> str:
    """The TOML text that describes a robot: one shipped with imitate, by name, or a file, by path.

    Raises:
        UnknownNameError: no such shipped robot.
        FileError: the file is missing or cannot be read.
    """
    path = Path(name)
    if not name.endswith(".toml"):
        shipped = {path.stem: path for path in _SHIPPED.glob("*.toml")}
        if name not in shipped:
            raise UnknownNameError("robot", name, shipped)
        path = shipped[name]
    try:
        return read_text(path)
    except FileNotFoundError:
        raise FileError(path, "no such robot description") from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as a robot's description ({error})") from None


def load_robot(name: str) -> Robot:
    """A robot shipped with imitate, by name, or described by a TOML file, by path.

    Raises:
        UnknownNameError: no such shipped robot.
        FileError: the file is missing, is no TOML, or lacks a field or has a wrong one.
    """
    return parse_robot(description_of(name), name)


def robot_of(spec: SceneSpec) -> Robot:
    """The robot of a scene, by the description that the scene carries; errors as in `load_robot`."""
    return parse_robot(spec.description, spec.robot) if spec.description else load_robot(spec.robot)


def parse_robot(text: str, name: str) -> Robot:
    """A robot from its TOML text; ``name`` is its file, beside which its URDF is looked for.

    Raises:
        FileError: no TOML, or a field is missing, unknown or wrong.
    """
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileError(name, f"is not TOML ({error})") from None
    _check_names(values, name)
    kinds = {f.name: str(f.type) for f in fields(Robot)}
    for key in _PER_FINGER:
        if not isinstance(values[key], list) and isinstance(values["fingers"], list):
            values[key] = [values[key]] * len(values["fingers"])
    for key, value in values.items():
        if not _fits(value, kinds[key]):
            kind = "a number, or one for each finger" if key in _PER_FINGER else _KINDS[kinds[key]]
            raise FileError(name, f"{key} = {value!r}", f"Expected {kind}.")
    _check_counts(values, name)
    beside = Path(name).parent / values["urdf"]
    if name.endswith(".toml") and beside.exists():
        values["urdf"] = str(beside.resolve())
    return Robot(**{key: _frozen(value) for key, value in values.items()})


def _check_names(values: Mapping[str, Any], name: str) -> None:
    needed = {f.name for f in fields(Robot) if f.default is MISSING and f.default_factory is MISSING}
    optional = {f.name for f in fields(Robot)} - needed
    if missing := sorted(needed - values.keys()):
        raise FileError(name, f"lacks {', '.join(missing)}", f"A robot has {', '.join(sorted(needed))}.")
    if unknown := sorted(values.keys() - needed - optional):
        raise FileError(
            name,
            f"has unknown {', '.join(unknown)}",
            f"A robot has {', '.join(sorted(needed))}, and may have {', '.join(sorted(optional))}.",
        )


def _check_counts(values: Mapping[str, Any], name: str) -> None:
    counts = {"tcp": (7, "7 numbers, x y z qx qy qz qw"), "rest": (len(values["arm"]), "one for each of arm")}
    counts |= {key: (len(values["fingers"]), "one for each of fingers") for key in _PER_FINGER}
    for key, (count, what) in counts.items():
        if len(values[key]) != count:
            raise FileError(name, f"{key} has {len(values[key])} numbers", f"Expected {what}: {count}.")
    for joint, travel in values.get("followers", {}).items():
        if len(travel) != 2:
            raise FileError(name, f"followers.{joint} has {len(travel)} numbers", "Expected open and closed.")
    still = [f for f, a, b in zip(*(values[k] for k in ("fingers", *_PER_FINGER)), strict=True) if a == b]
    if still:
        raise FileError(name, f"finger_open and finger_closed of {', '.join(still)} are the same")
    roles = [*values["arm"], *values["fingers"], *values.get("followers", {}), *values.get("held", {})]
    if twice := sorted({joint for joint in roles if roles.count(joint) > 1}):
        raise FileError(name, f"names {', '.join(twice)} twice", "A joint has one part to play.")
    for key in ("finger_lever", "finger_speed", "reach"):
        if values.get(key, 1.0) <= 0:
            raise FileError(name, f"{key} = {values[key]!r}", "Expected a number above 0.")


def _fits(value: Any, kind: str) -> bool:
    if kind.startswith("Mapping"):
        inner = kind.removeprefix("Mapping[str, ").removesuffix("]")
        return isinstance(value, dict) and all(_fits(item, inner) for item in value.values())
    if kind.startswith("tuple"):
        inner = kind.removeprefix("tuple[").removesuffix(", ...]")
        return isinstance(value, list) and len(value) > 0 and all(_fits(item, inner) for item in value)
    if kind == "str":
        return isinstance(value, str)
    return isinstance(value, int if kind == "int" else int | float) and not isinstance(value, bool)


def _frozen(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _frozen(item) for key, item in value.items()}
    return tuple(value) if isinstance(value, list) else value
