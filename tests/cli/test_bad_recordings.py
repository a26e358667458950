"""Each bad recording gets one message: what was looked for, what was found, and what to pass."""

import json

import numpy as np
import pytest
from bags import bag

from imitate import cli
from imitate.rgbd import Intrinsics

CAMERA = Intrinsics(64, 48, 60.0, 60.0, 31.5, 23.5)
GENERATOR = np.random.default_rng(2)
COLOUR = GENERATOR.integers(0, 255, (48, 64, 3)).astype(np.uint8)
STEPS = GENERATOR.integers(700, 2500, (48, 64)).astype(np.uint16)


def written(path, left_out=(), depth=(STEPS, "16UC1"), times=(0, 0.1, 0.2), apart=0.0):
    with bag(path) as made:
        for t in times:
            if "calibration" not in left_out:
                made.info("/camera/camera_info", CAMERA, t)
            if "depth" not in left_out:
                made.image("/camera/depth", *depth, t=t)
            if "colour" not in left_out:
                made.image("/camera/colour", COLOUR, "rgb8", t=t + apart)
    return path


def cut(path):
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 4 // 5])
    return path


@pytest.fixture
def refused(capsys, tmp_path, monkeypatch):
    """Runs `observe`, which has to fail with one message that names the file, and write nothing."""
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)

    def run(path, *words):
        with pytest.raises(SystemExit) as end:
            cli.main(["observe", str(path), "-o", "d.npz", *words])
        captured = capsys.readouterr()
        assert (end.value.code, captured.out) == (1, "")
        assert captured.err.startswith(f"error: {path}: ")
        assert "unexpected" not in captured.err
        assert list(empty.iterdir()) == []
        return captured.err

    return run


@pytest.mark.parametrize(
    ("made", "looked_for", "found", "to_do"),
    [
        (
            {"left_out": ["depth"]},
            "has no depth pictures",
            "/camera/colour (sensor_msgs/msg/Image)",
            "Looked for 16-bit or float pictures",
        ),
        (
            {"left_out": ["colour"]},
            "has no colour pictures",
            "/camera/depth (sensor_msgs/msg/Image)",
            "imitate demonstrate",
        ),
        (
            {"left_out": ["calibration"]},
            "has no calibration of its camera",
            "/camera/depth (sensor_msgs",
            "--intrinsics FX,FY,CX,CY",
        ),
        (
            {"depth": (STEPS.astype(np.float32), "32FC1")},
            "depths in an unknown unit",
            "at 1 m a step its middle reading is 1",
            "--depth-unit 0.001 for millimetres",
        ),
        (
            {"times": (0.0,)},
            "has one frame",
            "a demonstration needs at least 2",
            "PCD or PLY",
        ),
        (
            {"apart": 3.0},
            "colour and depth never pair within 0.04 s",
            "3 pictures in /camera/colour, 3 in /camera/depth; the nearest two are 2.8",
            "--pair-within",
        ),
        (
            {"depth": (STEPS, "16UC1")},
            "table",
            "its 3,072 readings lie 0.7",
            "--depth-unit 0.001 for millimetres",
        ),
    ],
    ids=["depth", "colour", "calibration", "unit", "one-frame", "pairs", "table"],
)
def test_what_was_looked_for_what_was_found_and_what_to_pass(
    refused, tmp_path, made, looked_for, found, to_do
):
    message = refused(written(tmp_path / "bad.mcap", **made))
    assert looked_for in message
    assert found in message
    assert to_do in message


def test_a_cut_recording_is_used_only_when_asked(refused, tmp_path):
    path = cut(written(tmp_path / "cut.mcap", times=np.arange(300) / 30))
    message = refused(path)
    assert "is damaged: cut at byte" in message
    assert "imitate observe FILE --salvage" in message
    assert "table" in refused(path, "--salvage")  # read as far as it goes, and there is no table in it


def test_the_options_may_be_settings(refused, tmp_path):
    path = written(tmp_path / "bad.mcap", left_out=["calibration"])
    settings = tmp_path / "camera.toml"
    settings.write_text("[perception]\nintrinsics = [60, 60, 31.5, 23.5]\n")
    assert "table" in refused(path, "--settings", str(settings))


def test_info_says_what_keeps_a_recording_from_being_used(capsys, tmp_path):
    cli_json = []
    for left_out in ((), ("calibration",)):
        with pytest.raises(SystemExit) as end:
            path = written(tmp_path / f"{len(left_out)}.mcap", left_out)
            cli.main(["info", str(path), "--json"])
        assert end.value.code == 0
        cli_json.append(json.loads(capsys.readouterr().out))
    whole, lacking = cli_json
    assert (whole["kind"], whole["frames"], whole["camera"]["fx"]) == ("recording", 3, 60)
    assert lacking["problem"].startswith("has no calibration of its camera; it has /camera/depth")
