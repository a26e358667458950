"""Every verb that reads a file says in one message what is wrong with it, and writes nothing."""

from pathlib import Path

import numpy as np
import pytest

from imitate import cli

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"


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
        (["--mode", "fast"], "'robust' or 'faithful'"),
    ],
)
def test_unknown_seeds_settings_and_options(refused, tmp_path, words, expected):
    typo = tmp_path / "typo.toml"
    typo.write_text("[learning]\nevaluation_stars = 5\n")
    code, message = refused("learn", FIXTURE, *(word.replace("{typo}", str(typo)) for word in words))
    assert code == 2
    assert expected in message
