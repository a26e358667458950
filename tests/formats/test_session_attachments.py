"""What a session's file tells tools that know no message of ours: mcap's own reader finds it."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest
import recorded
import scripted
from mcap.reader import make_reader
from refiled import cut, written

from imitate import events
from imitate.formats.decisions import read_decisions
from imitate.formats.mcap_file import McapReader
from imitate.formats.session_attachments import DECISIONS, ROBOT, SETTINGS
from imitate.record import RobotFile
from imitate.session.recovery import recover
from imitate.settings import settings_from_toml
from imitate.skill import Decision

URDF = "<robot name='mine'/>"
DESCRIPTION = 'urdf = "mine.urdf"\n'
DECISION = Decision("relabel", 1, abstraction=scripted.REACH)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    started, segmented, *rest = recorded.session()
    assert isinstance(started, events.SessionStarted)
    files = (RobotFile("mine.urdf", "ab" * 32, URDF), RobotFile("hand.stl", "cd" * 32))
    scene = replace(started.scene, robot="mine.toml", description=DESCRIPTION, robot_files=files)
    decided = events.Decided(DECISION, scripted.segments())
    story = [replace(started, scene=scene), segmented, decided, *rest]
    return written(tmp_path_factory.mktemp("log") / "s.mcap", story)


def attachments(path: Path) -> dict[str, bytes]:
    with path.open("rb") as stream:
        return {a.name: a.data for a in make_reader(stream).iter_attachments()}


def metadata(path: Path) -> dict[str, dict[str, str]]:
    with path.open("rb") as stream:
        return {m.name: m.metadata for m in make_reader(stream).iter_metadata()}


def test_settings_robot_and_decisions_are_files_in_it(session: Path, tmp_path: Path) -> None:
    found = attachments(session)
    assert found.keys() == {SETTINGS, ROBOT, "mine.urdf", DECISIONS}
    assert settings_from_toml(found[SETTINGS].decode()).learning.alpha == 0.8
    assert (found[ROBOT].decode(), found["mine.urdf"].decode()) == (DESCRIPTION, URDF)
    (tmp_path / DECISIONS).write_bytes(found[DECISIONS])
    assert read_decisions(tmp_path / DECISIONS) == (DECISION,)


def test_seed_versions_physics_and_hashes_are_metadata(session: Path) -> None:
    found = metadata(session)
    started = scripted.started()
    assert found["session"]["seed"] == str(started.seed)
    assert found["session"]["source_sha256"] == started.source_hash
    assert found["versions"].items() <= dict(started.versions).items()
    assert (found["physics"]["physics_rate"], found["physics"]["table_friction"]) == ("240", "0.8")
    hashes = {ROBOT: sha256(DESCRIPTION.encode()).hexdigest(), "mine.urdf": "ab" * 32, "hand.stl": "cd" * 32}
    assert found["robot"] == {"name": "mine.toml"} | hashes


def test_a_cut_session_has_them_from_its_start(session: Path, tmp_path: Path) -> None:
    reader = McapReader(cut(session, tmp_path / "cut.mcap", 0.5))
    assert sum(1 for _ in reader.messages())
    assert reader.attachments == attachments(session)


def test_a_recovered_session_keeps_them(session: Path, tmp_path: Path) -> None:
    recover(cut(session, tmp_path / "cut.mcap", 0.5), tmp_path / "clean.mcap")
    assert attachments(tmp_path / "clean.mcap") == attachments(session)
    assert metadata(tmp_path / "clean.mcap") == metadata(session)
