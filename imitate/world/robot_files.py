"""The files that a robot's description leads to: its URDF and the meshes that the URDF names."""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from imitate.errors import SceneError
from imitate.record import RobotFile, SceneSpec
from imitate.world.engine import data_path
from imitate.world.robot import Robot, robot_of


def urdf_path(robot: Robot) -> Path:
    """Where a robot's URDF or SDF is: as described, or within pybullet_data.

    Raises:
        SceneError: in neither place.
    """
    path = Path(robot.urdf)
    found = path if path.exists() else data_path() / path
    if not found.is_file():
        raise SceneError(
            f"{robot.urdf}: cannot be loaded as a robot, because there is no such file. Expected a URDF or "
            "SDF file: an absolute path, or one beside the robot's TOML file or within pybullet_data."
        )
    return found


def mesh_paths(urdf: Path) -> list[Path]:
    """The meshes that a URDF or an SDF names, each looked for beside it and in the folders above.

    Raises:
        SceneError: it is no XML, or meshes are not there; names them.
    """
    try:
        root = ElementTree.parse(urdf).getroot()
    except (ElementTree.ParseError, UnicodeDecodeError) as error:
        raise SceneError(f"{urdf}: cannot be loaded as a robot, because it is not XML ({error}).") from None
    named = [mesh.get("filename") or (mesh.findtext("uri") or "").strip() for mesh in root.iter("mesh")]
    found: list[Path] = []
    missing: list[str] = []
    for name in dict.fromkeys(filter(None, named)):
        relative = re.sub(r"^(package|model|file)://", "", name)
        places = [folder / relative.lstrip("/") for folder in urdf.resolve().parents]
        place = next((place for place in places if place.is_file()), None)
        if place is None:
            missing.append(name)
        else:
            found.append(place)
    if missing:
        raise SceneError(
            f"{urdf}: {len(missing)} of the {len(missing) + len(found)} meshes that it names are not there, "
            f"such as {missing[0]}. They are looked for beside the file and in the folders above it; "
            "copy the folders of meshes there too."
        )
    return found


def recorded_files(robot: Robot) -> tuple[RobotFile, ...]:
    """What a session keeps of a robot's files: the URDF whole, and of every mesh its hash.

    Raises:
        SceneError: a file is missing.
    """
    urdf = urdf_path(robot)
    text = urdf.read_text(encoding="utf-8", errors="replace")
    meshes = [
        RobotFile(os.path.relpath(mesh, urdf.parent.resolve()), _hash(mesh)) for mesh in mesh_paths(urdf)
    ]
    return RobotFile(urdf.name, _hash(urdf), text), *meshes


def located(spec: SceneSpec, robot: str = "") -> SceneSpec:
    """A recorded scene whose robot is here as it was.

    Args:
        spec: the scene.
        robot: the TOML file beside which the robot's files are now; empty for where they were.

    Raises:
        SceneError: a file is missing or differs; names the first.
    """
    spec = replace(spec, robot=robot) if robot else spec
    if not spec.robot_files:
        return spec
    where = f"They were looked for from where {spec.robot} lies"
    try:
        here = {file.name: file.sha256 for file in recorded_files(robot_of(spec))}
    except SceneError as error:
        raise SceneError(f"the recorded robot is not here: {error} {where}. {_REMEDY}") from None
    for file in spec.robot_files:
        if here.get(file.name) != file.sha256:
            raise SceneError(
                f"the recorded robot is not here: {file.name} differs; its SHA-256 begins "
                f"{here.get(file.name, '-')[:12]}, recorded was {file.sha256[:12]}. {where}. {_REMEDY}"
            )
    return spec


_REMEDY = "Put the files back as they were, or give --robot FILE.toml where a copy of them lies."


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
