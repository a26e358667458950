"""A robot of one's own: its files are found, recorded with the session, and missed where they are gone."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from imitate.errors import SceneError
from imitate.formats.messages import decode, describe, encode
from imitate.record import SceneSpec
from imitate.world.engine import data_path
from imitate.world.robot import _SHIPPED, load_robot
from imitate.world.robot_files import located, mesh_paths, recorded_files, urdf_path


@pytest.fixture
def own(tmp_path) -> Path:
    """A copy of the Panda that is not pybullet_data's: TOML, URDF and meshes in a folder."""
    shutil.copytree(data_path() / "franka_panda", tmp_path / "arm")
    description = (_SHIPPED / "panda.toml").read_text().replace("franka_panda/panda.urdf", "panda.urdf")
    (tmp_path / "arm" / "mine.toml").write_text(description)
    return tmp_path / "arm" / "mine.toml"


def recorded(toml: Path) -> SceneSpec:
    one = np.array([0, 0, 0, 0, 0, 0, 1.0])
    return SceneSpec(
        robot=str(toml),
        base=one,
        object_names=("cube",),
        object_sizes=np.full((1, 3), 0.04),
        object_masses=np.array([0.03]),
        object_poses=one[None],
        home=np.zeros(9),
        description=toml.read_text(),
        robot_files=recorded_files(load_robot(str(toml))),
    )


def test_the_urdf_is_kept_whole_and_every_mesh_by_its_hash(own):
    urdf, *meshes = recorded(own).robot_files
    assert urdf.name == "panda.urdf"
    assert urdf.text == (own.parent / "panda.urdf").read_text()
    assert len(meshes) == len(mesh_paths(own.parent / "panda.urdf"))
    assert all(
        mesh.name.startswith("meshes/") and not mesh.text and len(mesh.sha256) == 64 for mesh in meshes
    )


def test_a_recorded_scene_survives_its_message(own):
    spec = recorded(own)
    back = decode(SceneSpec, encode(spec, describe((SceneSpec,))))
    assert back.robot_files == spec.robot_files
    assert back.description == spec.description


def test_the_recorded_description_holds_when_its_file_is_gone(own):
    spec = recorded(own)
    own.unlink()
    assert located(spec) is spec


def test_a_urdf_that_changed_is_refused(own):
    spec = recorded(own)
    urdf = own.parent / "panda.urdf"
    urdf.write_text(urdf.read_text().replace('effort="87"', 'effort="88"'))
    with pytest.raises(SceneError, match=r"panda.urdf differs; its SHA-256 begins .*Put the files back"):
        located(spec)


def test_a_robot_that_moved_is_found_where_it_is_now(own, tmp_path):
    spec = recorded(own)
    moved = shutil.move(own.parent, tmp_path / "elsewhere")
    with pytest.raises(SceneError, match=r"recorded robot is not here: .*no such file.*--robot FILE.toml"):
        located(spec)
    assert located(spec, str(Path(moved) / "mine.toml")).robot.endswith("elsewhere/mine.toml")


def test_missing_meshes_are_counted_and_named(own):
    (own.parent / "meshes" / "collision" / "link3.obj").unlink()
    with pytest.raises(SceneError, match=r"1 of the \d+ meshes .* such as .*collision/link3.obj"):
        recorded_files(load_robot(str(own)))


def test_what_is_no_urdf_is_said(own):
    (own.parent / "panda.urdf").write_text("nothing")
    with pytest.raises(SceneError, match="it is not XML"):
        recorded_files(load_robot(str(own)))


@pytest.mark.parametrize("robot", sorted(path.stem for path in _SHIPPED.glob("*.toml")))
def test_every_shipped_robot_has_its_files(robot):
    urdf = urdf_path(load_robot(robot))
    assert len(mesh_paths(urdf)) > 5
