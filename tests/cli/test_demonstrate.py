"""imitate demonstrate: a recording, or one message."""

import json

import numpy as np
import pytest

from imitate.cli import main
from imitate.formats.demonstrations import read_demonstration, write_demonstration
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
        (("stack", "--viewpoint", "10,45"), 2, "--viewpoint '10,45': expected front, any, or azimuth"),
        (("stack", "--viewpoint", "10,95,1"), 2, "an elevation of 5 to 85 degrees"),
        (("stack", "--sensor", "kinnect"), 2, "unknown sensor 'kinnect'. Did you mean 'kinect'"),
        (("stack", "--room", "dark"), 2, "unknown room 'dark'"),
        (("stack", "--demonstration", "none.npz"), 1, "none.npz: no such file"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, capfd, words, code, message):
    assert run("demonstrate", *words, "-o", tmp_path / "x.mcap") == code
    assert message in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_how_the_times_of_what_is_filmed_are_read_is_said(moment, tmp_path, capfd):
    with np.load(moment) as held:
        np.savez(tmp_path / "ms.npz", **{**held, "t": 1000 * (held["t"] + 1.7e9)})
    words = (
        "-o",
        tmp_path / "film.mcap",
        "--demonstration",
        tmp_path / "ms.npz",
        "--size",
        "96x72",
        "--rate",
        "1",
    )
    assert run("demonstrate", "stack", *words) == 0
    assert f"{tmp_path / 'ms.npz'}: its times are milliseconds since 1970" in capfd.readouterr().err


def test_truth_is_written_beside(tmp_path, capfd):
    film, truth = tmp_path / "push.mcap", tmp_path / "push.npz"
    words = (
        "demonstrate",
        "push",
        "-o",
        film,
        "--truth",
        truth,
        "--size",
        "96x72",
        "--rate",
        "2",
        "--seed",
        2,
    )
    assert run(*words, "--viewpoint", "any", "--room", "any") == 0
    real, count = read_demonstration(truth), open_recording(film).count
    assert len(real.t) == count and len(real.object_names) == 2
    skills = json.loads((tmp_path / "push.json").read_text())["segments"]
    pushed, target = real.object_names
    assert [(s["relevant"], s["reference"]) for s in skills] == [
        (["hand"], pushed),
        (["hand", pushed], target),
        (["hand"], pushed),
    ]
    assert skills[0]["start"] == 0 and skills[1]["start"] == skills[0]["end"]
    before = truth.read_bytes()
    assert run(*words[:3], tmp_path / "other.mcap", *words[4:]) == 1
    assert "push.npz: exists already" in capfd.readouterr().err
    assert truth.read_bytes() == before and not (tmp_path / "other.mcap").exists()
