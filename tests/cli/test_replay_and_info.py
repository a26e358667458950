"""imitate replay and imitate info: contracts, exit codes and messages."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import recorded
import scripted

from imitate.demonstration import Demonstration
from imitate.events import TrialFinished
from imitate.formats.demonstrations import write_demonstration
from imitate.formats.session_writer import SessionWriter
from imitate.record import TrialRecord
from imitate.session.versions import versions
from imitate.settings import Settings, to_toml
from imitate.world.scene import World, scene_of, shown_start
from imitate.world.trial import Simulator

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"


@pytest.fixture(scope="module")
def story(short_demonstration: Demonstration):
    """A start and one short trial, as physics gives it."""
    scene = scene_of(short_demonstration, Settings().world)
    simulator = Simulator(World(scene, Settings().world), Settings())
    z = np.zeros
    commands = np.tile(np.append(scene.home[:7], 20.0), (10, 1))
    asked = TrialRecord(
        shown_start(scene), 1 / 240, 4, (0,), commands,
        z((40, 9)), z((40, 9)), z((40, 7)), z((40, 2, 7)), z((40, 2, 6)), z((40, 2)),
    )  # fmt: skip
    record = simulator.resimulate(asked)
    simulator.close()
    started = replace(
        scripted.started(),
        settings=to_toml(Settings()),
        versions=versions(),
        demonstration=short_demonstration,
        scene=scene,
    )
    return started, replace(scripted.trial(1, 0, 4, "explore", 0, 20.0, ""), record=record)


def written(path: Path, *events) -> Path:
    with SessionWriter(path) as log:
        for event in events:
            log.write(event)
    return path


def one_ulp_off(trial: TrialFinished) -> TrialFinished:
    poses = np.array(trial.record.object_poses)
    poses[7, 1, 2] = np.nextafter(poses[7, 1, 2], 1)
    return replace(trial, record=replace(trial.record, object_poses=poses))


def test_replay_json_keeps_its_contract(imitate, tmp_path, story):
    path = written(tmp_path / "s.mcap", *story)
    code, out, err = imitate("replay", path, "--json", "--workers", 1)
    assert (code, err) == (0, "")
    assert json.loads(out) == {"steps": 40, "divergent": 0, "first_divergence": None}


def test_a_divergence_is_exit_code_3_and_names_step_and_field(imitate, tmp_path, story):
    started, trial = story
    path = written(tmp_path / "s.mcap", started, one_ulp_off(trial))
    code, out, _ = imitate("replay", path, "--json", "--workers", 1)
    assert code == 3
    result = json.loads(out)
    first = result["first_divergence"]
    name = started.scene.object_names[1]
    assert (result["steps"], result["divergent"]) == (40, 1)
    assert (first["step"], first["segment"], first["trial"]) == (7, 1, 4)
    assert first["field"] == f"object_poses[{name}].z"
    assert first["recorded"] == np.nextafter(first["replayed"], 1)
    code, out, _ = imitate("replay", path, "--workers", 1)
    assert code == 3
    assert f"First at step 7 of trial 4 of segment 1, formulation 0: object_poses[{name}].z was" in out


def test_replay_writes_for_rerun_and_never_over_a_file(imitate, tmp_path, story):
    path, rrd = written(tmp_path / "s.mcap", *story), tmp_path / "s.rrd"
    code, out, err = imitate("replay", path, "--rrd", rrd, "--workers", 1)
    assert code == 0
    assert out == "40 steps of 1 trials replayed: every double of every step is the same.\n"
    assert f"open it with `rerun {rrd}`" in err
    size = rrd.stat().st_size
    assert size > 1000
    code, out, err = imitate("replay", path, "--rrd", rrd)
    assert (code, out) == (1, "")
    assert "exists already. Choose another name, or overwrite it with --force." in err
    assert imitate("replay", path, "--rrd", rrd, "--force", "--workers", 1)[0] == 0


def test_replay_of_a_cut_session_says_so(imitate, tmp_path, story):
    data = written(tmp_path / "s.mcap", *story).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) - 2000])
    code, out, err = imitate("replay", cut, "--json", "--workers", 1)
    assert code == 3
    assert json.loads(out)["divergent"] == 0
    assert "cut.mcap is damaged: cut at byte" in err


@pytest.mark.parametrize("verb", ["replay", "info"])
def test_what_is_no_file_of_ours(imitate, tmp_path, verb):
    text = tmp_path / "text.mcap"
    text.write_text("hello there")
    code, out, err = imitate(verb, text)
    assert (code, out) == (1, "")
    assert err.startswith(f"error: {text}: is not an MCAP file: it starts with b'hello th'.")
    code, _, err = imitate(verb, tmp_path / "none.mcap")
    assert code == 1
    assert err.startswith(f"error: {tmp_path / 'none.mcap'}: no such file.")
    assert "Traceback" not in err


def test_replay_of_a_demonstration_is_refused(imitate, tmp_path):
    path = tmp_path / "demo.mcap"
    write_demonstration(scripted.demonstration(), path)
    code, _, err = imitate("replay", path)
    assert code == 1
    assert err == f"error: {path}: is not a session of imitate. `imitate info` says what it is.\n"


def test_info_of_a_session(imitate, tmp_path):
    path = written(tmp_path / "s.mcap", *recorded.session(8))
    code, out, err = imitate("info", path, "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert result["kind"] == "session"
    assert (result["complete"], result["trials"], result["seed"]) == (True, 130, 3)
    assert result["objects"] == ["blue", "green"]
    assert result["topics"]["/costs"] == {"schema": "std_msgs/msg/Float64MultiArray", "messages": 130}
    code, out, _ = imitate("info", path)
    assert code == 0
    assert "/imitate/trial_finished" in out


def test_info_of_demonstrations(imitate, tmp_path):
    code, out, _ = imitate("info", FIXTURE, "--json")
    result = json.loads(out)
    assert (code, result["kind"], result["frames"]) == (0, "demonstration", 1252)
    assert result["objects"][0] == {"name": "cubeA", "size": [0.04, 0.04, 0.04]}
    path = tmp_path / "demo.mcap"
    write_demonstration(scripted.demonstration(), path)
    code, out, _ = imitate("info", path)
    assert code == 0
    assert "blue, 40 × 40 × 40 mm" in out


def test_info_of_a_damaged_file_is_exit_code_3(imitate, tmp_path):
    data = bytearray(written(tmp_path / "s.mcap", *recorded.session(8)).read_bytes())
    data[len(data) // 2] ^= 1
    path = tmp_path / "flipped.mcap"
    path.write_bytes(data)
    code, out, _ = imitate("info", path, "--json")
    assert code == 3
    assert json.loads(out)["damage"][0].startswith("a damaged chunk that ends at byte")
    assert json.loads(out)["complete"] is False


def die(*_: object) -> None:
    """What a worker does that is killed."""
    os._exit(9)


def test_a_worker_that_is_killed_is_no_fault_of_ours(imitate, story, tmp_path, monkeypatch):
    path = written(tmp_path / "a.mcap", *story)
    monkeypatch.setattr("imitate.session.replay.run_again", die)
    code, out, err = imitate("replay", path, "--workers", 2)
    assert (code, out) == (1, "")
    assert err.startswith("error: a process that ran trials died (")
    assert err.endswith("Was it killed, or is the memory full? Try again with --workers 1.\n")
