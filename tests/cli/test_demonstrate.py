"""imitate demonstrate: a recording, or one message."""

import pytest

from imitate.cli import main
from imitate.formats.demonstrations import write_demonstration
from imitate.formats.recordings import open_recording


def run(*words):
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return end.value.code or 0


@pytest.fixture(scope="module")
def moment(short_demonstration, tmp_path_factory):
    path = tmp_path_factory.mktemp("moment") / "moment.npz"
    write_demonstration(short_demonstration, path)
    return path


def test_films_and_never_overwrites(moment, tmp_path, capfd):
    output = tmp_path / "film.mcap"
    words = (
        "demonstrate",
        "stack",
        "-o",
        output,
        "--demonstration",
        moment,
        "--size",
        "96x72",
        "--rate",
        "2",
    )
    assert run(*words) == 0
    said = capfd.readouterr()
    assert said.out == ""
    assert "film.mcap: 15 frames of 96×72" in said.err
    recording = open_recording(output)
    assert recording.count == 15 and recording.intrinsics.width == 96
    before = output.read_bytes()
    assert run(*words) == 1
    assert "exists already" in capfd.readouterr().err
    assert output.read_bytes() == before
    assert run(*words, "--force") == 0
    assert output.read_bytes() == before  # the same seed
    assert run(*words, "--force", "--seed", "1") == 0
    assert output.read_bytes() != before


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("stak",), 2, "unknown task 'stak'. Did you mean 'stack'?"),
        (("stack", "--size", "big"), 2, "--size 'big': expected WIDTHxHEIGHT"),
        (("stack", "--demonstration", "none.npz"), 1, "none.npz: no such file"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, capfd, words, code, message):
    assert run("demonstrate", *words, "-o", tmp_path / "x.mcap") == code
    assert message in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []
