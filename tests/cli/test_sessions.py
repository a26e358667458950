"""imitate sessions: what is listed and what is deleted."""

import json
import os
import time
from pathlib import Path

import pytest
import scripted

from imitate.events import SessionFinished
from imitate.formats.session_log import summarise
from imitate.formats.session_writer import SessionWriter


def written(path, reproduced=True, finished=True):
    with SessionWriter(path) as log:
        for event in scripted.session(reproduced):
            if finished or not isinstance(event, SessionFinished):
                log.write(event)
    return path


@pytest.fixture
def shelf(tmp_path):
    """A session of each kind, a day apart, the one that was cut the oldest; and a file that is none."""
    written(tmp_path / "good.mcap")
    written(tmp_path / "bad.mcap", reproduced=False)
    written(tmp_path / "stopped.mcap", finished=False)
    whole = written(tmp_path / "cut.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "cut.rrd").write_bytes(b"view")
    (tmp_path / "other.mcap").write_bytes(b"no MCAP")
    for age, name in enumerate(("good", "bad", "stopped", "cut")):
        then = time.time() - 86400 * age
        os.utime(tmp_path / f"{name}.mcap", (then, then))
    return tmp_path


def test_each_is_listed_with_how_it_ended_the_latest_first(imitate, shelf):
    code, said, _ = imitate("sessions", shelf, "--json")
    found = json.loads(said)
    assert code == 0
    assert [(e["session"].rsplit("/", 1)[-1], e["outcome"], e["complete"]) for e in found] == [
        ("good.mcap", "reproduced", True),
        ("bad.mcap", "not reproduced", True),
        ("stopped.mcap", "stopped", False),
        ("cut.mcap", "cut", False),
    ]
    assert {(e["source"], e["seed"]) for e in found[:3]} == {("stack.npz", 3)}


def test_a_session_that_is_being_written_is_running_and_is_never_deleted(imitate, tmp_path):
    with SessionWriter(tmp_path / "now.mcap") as log:
        for event in list(scripted.session())[:20]:
            log.write(event)
        code, said, _ = imitate("sessions", tmp_path, "--json")
        assert (code, json.loads(said)[0]["outcome"]) == (0, "running")
        imitate("sessions", tmp_path, "--prune", "any", "--yes")
    assert (tmp_path / "now.mcap").exists()


def test_those_named_are_deleted_with_what_lies_beside_them(imitate, shelf):
    code, _, said = imitate("sessions", shelf, "--prune", "cut", "--prune", "not-reproduced", "--yes")
    assert code == 0
    assert "2 sessions" in said and "deleted" in said
    left = {path.name for path in shelf.iterdir()}
    assert left == {"good.mcap", "stopped.mcap", "other.mcap"}


def test_only_those_old_enough_are_deleted(imitate, shelf):
    imitate("sessions", shelf, "--prune", "any", "--older", "1.5", "--yes")
    assert {path.stem for path in shelf.glob("*.mcap")} == {"good", "bad", "other"}


def test_nothing_is_deleted_without_a_yes(imitate, shelf):
    code, _, said = imitate("sessions", shelf, "--prune", "cut", "--json")
    assert code == 2
    assert "1 session, " in said and "would be deleted; say so with --yes." in said
    assert (shelf / "cut.mcap").exists()


def test_a_wrong_outcome_lists_the_right_ones(imitate, shelf):
    code, _, said = imitate("sessions", shelf, "--prune", "failed")
    assert code == 2
    assert "Valid: any, cut, not-reproduced, reproduced, stopped." in said


def test_an_age_alone_is_refused(imitate, shelf):
    code, _, said = imitate("sessions", shelf, "--older", "3")
    assert (code, "--older says what --prune deletes" in said) == (2, True)


def test_no_such_folder(imitate, tmp_path):
    code, _, said = imitate("sessions", tmp_path / "none")
    assert (code, "no such folder" in said) == (1, True)


def test_one_that_may_not_be_read_hides_none_of_the_others(imitate, shelf, monkeypatch):
    def refuse(path):
        if path.name == "bad.mcap":
            raise PermissionError(13, "Permission denied", str(path))
        return summarise(path)

    monkeypatch.setattr("imitate.session.shelf.summarise", refuse)
    code, said, _ = imitate("sessions", shelf, "--json")
    assert code == 0
    assert {Path(e["session"]).name for e in json.loads(said)} == {"good.mcap", "stopped.mcap", "cut.mcap"}
