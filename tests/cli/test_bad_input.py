"""Every verb that reads a file says in one message what is wrong with it, and writes nothing."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from imitate import cli, world

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"
PANDA = Path(world.__file__).parent / "robots" / "panda.toml"


def spoiled(path: Path, **changes: np.ndarray | None) -> Path:
    """The human demonstration with arrays replaced, or left out where None."""
    with np.load(FIXTURE) as archive:
        arrays = {name: archive[name] for name in archive.files} | changes
    np.savez(path, **{name: values for name, values in arrays.items() if values is not None})
    return path


def widened(name: str) -> np.ndarray:
    with np.load(FIXTURE) as archive:
        poses = archive[name]
    poses[..., :2] *= 8
    return poses


@pytest.fixture
def refused(capsys, tmp_path, monkeypatch):
    """Runs a command line in an empty folder; it has to fail with one message and leave the folder empty."""
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)

    def run(*words: object) -> tuple[int, str]:
        with pytest.raises(SystemExit) as end:
            cli.main([str(word) for word in words])
        captured = capsys.readouterr()
        assert captured.out == ""
        assert "Traceback" not in captured.err
        assert "unexpected" not in captured.err
        assert list(empty.iterdir()) == []
        return end.value.code, captured.err

    return run


READERS = ["observe", "segment", "learn", "reproduce", "replay", "info"]


@pytest.mark.parametrize("verb", READERS)
def test_a_missing_file(refused, verb):
    code, message = refused(verb, "none.mcap")
    assert code == 1
    assert message.startswith("error: none.mcap: no such file")


@pytest.mark.parametrize("verb", READERS)
def test_a_text_file_called_mcap(refused, verb, tmp_path):
    text = tmp_path / "notes.mcap"
    text.write_text("Dear diary, today I stacked a block.\n")
    code, message = refused(verb, text)
    assert code == 1
    assert f"{text}: is not an MCAP file: it starts with b'Dear dia'" in message
    assert text.read_text().startswith("Dear diary")


@pytest.mark.parametrize("verb", ["segment", "learn"])
def test_a_demonstration_without_a_hand(refused, verb, tmp_path):
    code, message = refused(verb, spoiled(tmp_path / "handless.npz", hand=None))
    assert code == 1
    assert "has no array 'hand'" in message
    assert "A demonstration holds t (T,), hand (T, 7)" in message


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        (None, "no object's size is known"),
        (np.array([[np.nan] * 3, [0.05] * 3]), "the size of cubeA is not known, so it cannot be simulated"),
    ],
)
def test_an_object_of_unknown_size_is_segmented_and_not_learned(refused, tmp_path, sizes, expected, capsys):
    file = spoiled(tmp_path / "sizeless.npz", object_sizes=sizes)
    code, message = refused("learn", file)
    assert code == 1
    assert expected in message
    with pytest.raises(SystemExit) as end:
        cli.main(["segment", str(file), "--json"])
    assert end.value.code == 0
    assert '"reference": "cubeB"' in capsys.readouterr().out


def test_a_demonstration_out_of_reach(refused, tmp_path):
    file = spoiled(tmp_path / "wide.npz", hand=widened("hand"), objects=widened("objects"))
    code, message = refused("learn", file)
    assert code == 1
    assert "out of reach" in message
    assert "above the table" in message


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--seed", "x"], "'--seed'"),
        (["--seed", "-1"], "'--seed'"),
        (["--sed", "1"], "No such option"),
        (["--settings", "{typo}"], "Did you mean 'evaluation_starts'?"),
        (["--mode", "fast"], "'robust', 'faithful' or 'cst'"),
    ],
)
def test_unknown_seeds_settings_and_options(refused, tmp_path, words, expected):
    typo = tmp_path / "typo.toml"
    typo.write_text("[learning]\nevaluation_stars = 5\n")
    code, message = refused("learn", FIXTURE, *(word.replace("{typo}", str(typo)) for word in words))
    assert code == 2
    assert expected in message


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"urdf": "nothing.urdf"}, "nothing.urdf: cannot be loaded as a robot"),
        ({"fingers": ["paw", "claw"]}, "no joint paw, claw; its movable joints are panda_joint1,"),
        ({"hand_link": "paw"}, "no link paw; it has"),
        (
            {"finger_open": "wide"},
            "finger_open = ['wide', 'wide']. Expected a number, or one for each finger",
        ),
        ({"fingers": []}, "fingers = []. Expected a list of names"),
        ({"rest": [0.0]}, "rest has 1 numbers. Expected one for each of arm: 7"),
    ],
)
def test_a_wrong_description_of_a_robot(refused, tmp_path, change, expected):
    description = tomllib.loads(PANDA.read_text()) | change
    robot = tmp_path / "robot.toml"
    robot.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in description.items()))
    settings = tmp_path / "settings.toml"
    settings.write_text(f"[world]\nrobot = {json.dumps(str(robot))}\n")
    code, message = refused("learn", FIXTURE, "--settings", settings)
    assert code == 1
    assert expected in message


def test_a_demonstration_too_short_to_move_in(refused, tmp_path):
    with np.load(FIXTURE) as archive:
        two = {name: archive[name][:2] for name in ("t", "hand", "objects")}
    code, message = refused("learn", spoiled(tmp_path / "short.npz", **two))
    assert code == 1
    assert "lasts 0.01 s; expected at least" in message


@pytest.mark.parametrize("words", [["learn", FIXTURE], ["demonstrate", "stack"]])
def test_an_output_of_another_kind(refused, words):
    code, message = refused(*words, "-o", "new.rrd")
    assert code == 1
    assert "new.rrd: cannot be written: unknown suffix '.rrd'. Use .mcap." in message


@pytest.mark.parametrize("verb", ["observe", "reproduce", "replay"])
def test_a_demonstration_where_something_else_is_expected(refused, verb):
    code, message = refused(verb, FIXTURE)
    assert code == 1
    assert "An NPZ holds a demonstration: imitate learn" in message


@pytest.mark.parametrize("verb", ["segment", "learn"])
def test_columns_that_mean_nothing_to_us(refused, verb, tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("stamp,ax,ay,az\n0,1,2,3\n1,2,3,4\n")
    code, message = refused(verb, file)
    assert code == 1
    assert "its columns are stamp, ax, ay, az" in message
    assert "pass it with --mapping FILE.toml" in message
    mapping = tmp_path / "mapping.toml"
    mapping.write_text('hand.position = ["ax", "ay", "aw"]\nobjects.cube.position = ["ax", "ay", "az"]\n')
    code, message = refused(verb, file, "--mapping", mapping)
    assert code == 1
    assert "has no column 'aw' (for hand)" in message


def test_decisions_that_cannot_be_applied_start_no_learning(refused, tmp_path):
    decisions = tmp_path / "decisions.json"
    decisions.write_text('[{"kind": "merge", "segment": 4}]')
    code, message = refused("learn", FIXTURE, "--decisions", decisions)
    assert code == 2
    assert "decision 1 (merge): there are no segments 4 and 5" in message
