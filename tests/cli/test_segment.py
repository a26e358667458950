"""imitate segment: JSON, table, and one clear message for each kind of bad input."""

import json
from pathlib import Path

import numpy as np
import pytest

from imitate.session import source
from imitate.session.source import Source

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"


@pytest.fixture
def arrays() -> dict[str, np.ndarray]:
    with np.load(FIXTURE) as archive:
        return {name: archive[name] for name in archive.files}


@pytest.mark.parametrize("mode", ["robust", "faithful"])
def test_json_keeps_its_contract(imitate, mode):
    code, out, err = imitate("segment", FIXTURE, "--mode", mode, "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert set(result) == {"mode", "segments", "boundaries"}
    assert len(result["boundaries"]) == len(result["segments"]) - 1
    for boundary, s in zip(result["boundaries"], result["segments"], strict=False):
        assert boundary["time"] == s["end"]
        assert boundary["low"] <= boundary["high"]
        assert len(boundary["times"]) == len(boundary["probability"])
        assert 0.99 < sum(boundary["probability"]) <= 1 + 1e-9
    assert result["mode"] == mode
    for s in result["segments"]:
        assert set(s) == {"start", "end", "relevant", "reference", "alternatives"}
        assert s["relevant"][0] == "hand"
        for alternative in s["alternatives"]:
            assert set(alternative) == {"relevant", "reference", "log_likelihood"}
    if mode == "robust":
        assert [(s["relevant"], s["reference"]) for s in result["segments"]] == [
            (["hand"], "cubeA"),
            (["hand", "cubeA"], "cubeB"),
        ]


@pytest.mark.parametrize(("left_out", "ends"), [(0.5, 3), (0.05, 0)])
def test_what_a_recording_lost_is_told_and_counts(imitate, human_stack, monkeypatch, left_out, ends):
    lost = Source("film", "", human_stack, notes=("half is gone",), left_out=left_out)
    monkeypatch.setattr(source, "read_source", lambda *_: lost)
    code, out, err = imitate("segment", "film.mcap", "--json")
    assert (code, err) == (ends, "film.mcap: half is gone\n")
    assert len(json.loads(out)["segments"]) == 2


def test_times_that_are_no_seconds_are_told(imitate, arrays, tmp_path):
    np.savez(tmp_path / "ms.npz", **{**arrays, "t": 1000 * (arrays["t"] + 1.7e9)})
    words = "its times are milliseconds since 1970 and read as such; time_unit in a mapping says otherwise"
    code, _, err = imitate("segment", tmp_path / "ms.npz")
    assert (code, err) == (0, f"{tmp_path / 'ms.npz'}: {words}\n")
    code, out, _ = imitate("info", tmp_path / "ms.npz", "--json")
    assert (code, json.loads(out)["notes"]) == (0, [words])


@pytest.mark.slow
def test_a_recording_is_observed_first(imitate):
    code, out, err = imitate("segment", FIXTURE.with_name("stack.mcap"), "--json")
    assert (code, err) == (0, "")
    assert [(s["relevant"], s["reference"]) for s in json.loads(out)["segments"]] == [
        (["hand"], "blue"),
        (["hand", "blue"], "green"),
        (["hand"], "blue"),
    ]


def test_the_table_names_skills_and_runners_up(imitate):
    code, out, _ = imitate("segment", FIXTURE)
    assert code == 0
    assert "hand, cubeA" in out
    assert "⟨{hand}, cubeB⟩" in out


def test_the_settings_file_chooses_the_mode(imitate, tmp_path):
    file = tmp_path / "paper.toml"
    file.write_text('mode = "faithful"\n')
    code, out, _ = imitate("segment", FIXTURE, "--settings", file, "--json")
    assert code == 0
    assert json.loads(out)["mode"] == "faithful"


def test_decisions_are_applied(imitate, tmp_path):
    file = tmp_path / "decisions.json"
    file.write_text('[{"kind": "move", "segment": 0, "time": 8.25}]')
    code, out, _ = imitate("segment", FIXTURE, "--decisions", file, "--json")
    assert code == 0
    reach, carry = json.loads(out)["segments"]
    assert reach["end"] == carry["start"] == 8.25
    file.write_text('[{"kind": "merge", "segment": 1}]')
    code, out, err = imitate("segment", FIXTURE, "--decisions", file)
    assert (code, out) == (2, "")
    assert err.startswith("error: decision 1 (merge): there are no segments 1 and 2")


def test_decisions_that_explain_far_less_are_applied_and_said(imitate, tmp_path):
    file = tmp_path / "decisions.json"
    file.write_text('[{"kind": "merge", "segment": 0}]')
    code, out, err = imitate("segment", FIXTURE, "--decisions", file, "--json")
    assert code == 0
    assert len(json.loads(out)["segments"]) == 1
    assert "skill 1: the motion is e^-" in err
    assert "times as likely uncut as cut at 8.50 s; kept, as you decided" in err


def without_hand(arrays):
    return {name: values for name, values in arrays.items() if name != "hand"}


def nan_in_a_pose(arrays):
    arrays["objects"][7, 1, 2] = np.nan
    return arrays


def long_quaternion(arrays):
    arrays["hand"][3, 3:] *= 1.5
    return arrays


def backwards(arrays):
    arrays["t"][10] = arrays["t"][8]
    return arrays


@pytest.mark.parametrize(
    ("spoil", "messages"),
    [
        (without_hand, ["has no array 'hand'", "t (1252,)"]),
        (nan_in_a_pose, ["objects[:, 1] (cubeB)", "NaN or infinite at frame 7", "1 frames in all"]),
        (long_quaternion, ["hand: quaternion of length 1.5 at frame 3", "expected unit quaternions"]),
        (backwards, ["t: goes from", "at frame 10", "strictly increasing"]),
    ],
)
def test_bad_arrays_are_named(imitate, arrays, tmp_path, spoil, messages):
    file = tmp_path / "bad.npz"
    np.savez(file, **spoil(arrays))
    code, out, err = imitate("segment", file)
    assert (code, out) == (1, "")
    assert err.startswith(f"error: {file}")
    assert err.count("\n") == 1
    for message in messages:
        assert message in err


def test_bad_files_and_words(imitate, tmp_path):
    text = tmp_path / "notes.mcap"
    text.write_text("Dear diary, today I stacked a block.\n")
    typo = tmp_path / "typo.toml"
    typo.write_text("[segmentation]\nwindw = 3\n")
    far = tmp_path / "far.toml"
    far.write_text("[segmentation]\nrate = -1\n")
    for words, expected, message in [
        (["segment", tmp_path / "none.npz"], 1, "no such file"),
        (["segment", text], 1, "not an MCAP file"),
        (["segment", FIXTURE, "--settings", typo], 2, "Did you mean 'window'?"),
        (["segment", FIXTURE, "--settings", far], 2, "segmentation.rate = -1"),
        (["segment", FIXTURE, "--settings", tmp_path / "none.toml"], 1, "no such settings file"),
        (["segment", FIXTURE, "--mode", "fast"], 2, "'robust', 'faithful' or 'cst'"),
        (["segment"], 2, "Missing argument"),
    ]:
        code, out, err = imitate(*words)
        assert (code, out) == (expected, ""), err
        assert message in err
        assert "Traceback" not in err


def test_nothing_is_written(imitate, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    imitate("segment", FIXTURE)
    assert list(tmp_path.iterdir()) == []


def test_a_reviewed_segmentation_serves_as_truth(imitate, tmp_path):
    code, out, _ = imitate("segment", FIXTURE, "--json")
    truth = tmp_path / "truth.json"
    truth.write_text(out)
    decisions = tmp_path / "decisions.json"
    decisions.write_text('[{"kind": "move", "segment": 0, "time": 8.0}]')
    words = ["segment", FIXTURE, "--truth", truth, "--decisions", decisions]
    code, out, _ = imitate(*words)
    assert code == 0
    assert "boundaries: 1 of the 1 found are right (precision 1.00)" in out
    assert "in 2 of the 2 right skills" in out
    code, out, _ = imitate(*words, "--tolerance", 0.1, "--json")
    metrics = json.loads(out)["metrics"]
    assert (metrics["precision"], metrics["recall"], metrics["segments_right"]) == (0, 0, 2)
    truth.write_text(truth.read_text().replace("cubeB", "cubeC"))
    code, out, err = imitate(*words)
    assert (code, out) == (1, "")
    assert "names 'cubeC', which the demonstration has not. It has cubeA, cubeB" in err


def test_columns_are_named_by_a_mapping(imitate, arrays, tmp_path):
    poses = {"clock": arrays["t"], "ee": arrays["hand"]}
    poses |= {name: arrays["objects"][:, k] for k, name in enumerate(("a", "b"))}
    np.savez(tmp_path / "mine.npz", **poses)
    mapping = tmp_path / "mapping.toml"
    mapping.write_text('time = "clock"\nhand.pose = "ee"\nobjects.cube.pose = "a"\nobjects.base.pose = "b"\n')
    code, out, _ = imitate("segment", tmp_path / "mine.npz", "--mapping", mapping, "--json")
    assert code == 0
    assert [(s["relevant"], s["reference"]) for s in json.loads(out)["segments"]] == [
        (["hand"], "cube"),
        (["hand", "cube"], "base"),
    ]


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_picture_is_drawn(imitate, tmp_path, suffix):
    picture = tmp_path / f"skills{suffix}"
    code, _, err = imitate("segment", FIXTURE, "--plot", picture)
    assert (code, err) == (0, f"picture: {picture}\n")
    first = picture.read_bytes()
    assert first.startswith(b"\x89PNG" if suffix == ".png" else b"<?xml")
    code, out, err = imitate("segment", FIXTURE, "--plot", picture)
    assert (code, out) == (1, "")
    assert "exists already" in err
    imitate("segment", FIXTURE, "--plot", picture, "--force")
    assert picture.read_bytes() == first


def test_a_picture_of_another_kind(imitate, tmp_path):
    code, out, err = imitate("segment", FIXTURE, "--plot", tmp_path / "skills.pdf")
    assert (code, out) == (1, "")
    assert "cannot be drawn: unknown suffix '.pdf'. Use .png or .svg." in err
