"""The pipeline against the truth that the virtual camera filmed; perception itself never sees that truth."""

import json
import subprocess
import sys

import numpy as np
import pytest
from recorded import same
from scipy.spatial.transform import Rotation

from imitate.cli import main
from imitate.demonstration import Demonstration
from imitate.errors import FileError, ImitateError
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.recordings import open_recording, write_recording
from imitate.geometry import angle_between, compose, from_yaw, quaternion_multiply, rotate
from imitate.perception.observe import observe
from imitate.rgbd import RgbdFrame
from imitate.settings import Perception, Settings
from imitate.world import stage
from imitate.world.demonstrator import film, plan_film
from imitate.world.performance import Performance


@pytest.fixture(scope="session")
def world_from_table(filmed, observed):
    return compose(filmed.world_from_camera, observed.camera_from_table)


def test_table_is_found_level_and_at_its_height(world_from_table):
    assert abs(world_from_table[2]) < 0.001
    assert rotate(world_from_table[3:], [0, 0, 1.0])[2] > np.cos(np.deg2rad(0.3))


def test_blocks_are_named_by_hue_and_measured(observed):
    assert observed.demonstration.object_names == ("blue", "green")
    np.testing.assert_allclose(observed.demonstration.size_of("blue"), 0.04, atol=0.002)
    np.testing.assert_allclose(observed.demonstration.size_of("green"), 0.05, atol=0.002)


@pytest.mark.parametrize(("name", "k"), [("blue", 0), ("green", 1)])
def test_blocks_are_followed_through_grasp_and_carry(filmed, observed, world_from_table, name, k):
    found = compose(world_from_table, observed.demonstration.pose_of(name))
    real = filmed.truth.demonstration.objects[:, k]
    away = np.linalg.norm(found[:, :3] - real[:, :3], axis=1)
    assert np.median(away) < 0.002 and away.max() < 0.006
    apart = [
        np.median(angle_between(quaternion_multiply(found[:, 3:], turn), real))
        for turn in Rotation.create_group("O").as_quat()  # a cube looks the same after these
    ]
    assert min(apart) < np.deg2rad(2)


def test_hand_is_found_at_its_fingertips(filmed, observed, world_from_table):
    found = compose(world_from_table, observed.demonstration.hand)
    real = filmed.truth.demonstration.hand
    away = np.linalg.norm(found[:, :3] - real[:, :3], axis=1)
    assert np.median(away) < 0.0025 and away.max() < 0.006
    assert np.median(angle_between(found, real)) < np.deg2rad(2)


def test_the_hands_opening_is_measured(filmed, observed):
    away = np.abs(observed.demonstration.opening - filmed.truth.opening)
    assert np.median(away) < 0.001 and np.percentile(away, 90) < 0.004


def test_nothing_in_view_is_lost(observed):
    assert observed.lost == {}


def test_being_watched_changes_nothing(filmed, observed):
    moments = []
    watched = observe(filmed.path, seed=3, watch=moments.append)
    assert same(watched, observed)
    poses = np.array([[sight.pose for sight in moment.sights] for moment in moments])
    d = watched.demonstration
    np.testing.assert_array_equal(poses[:, 0, :3], d.hand[:, :3])  # the signs of turns are aligned later
    np.testing.assert_array_equal(poses[:, 1:, :3], d.objects[..., :3])
    np.testing.assert_array_equal([[s.confidence for s in m.sights] for m in moments], observed.confidence)
    np.testing.assert_array_equal([m.opening for m in moments], observed.demonstration.opening)
    assert [m.count for m in moments] == [len(moments)] * len(moments)


def test_the_papers_origin_is_undone(filmed, observed, tmp_path):
    settings = Settings.model_validate({"perception": {"hand_offset": 0.1}})
    shifted = observe(_rewritten(filmed, tmp_path / "same.mcap", lambda _, frame: frame), settings)
    apart = shifted.demonstration.hand[:, :3] - observed.demonstration.hand[:14, :3]
    assert np.linalg.norm(apart, axis=1).max() < 0.006


def test_blocks_of_one_hue_are_numbered_and_kept_apart(tmp_path, monkeypatch):
    """Two blue blocks of other shapes, the smaller carried past the larger one."""
    monkeypatch.setattr(stage, "BLOCKS", ("blue", "blue"))
    t = np.linspace(0, 3, 31)
    way = np.clip(t - 0.9, 0, 1.6) / 1.6
    path_of_small = np.stack([0.1 * way, 0.06 - 0.11 * way, 0.02 + 0.06 * np.sin(np.pi * way)], axis=1)
    small = from_yaw(path_of_small, np.full(31, 0.3))
    large = from_yaw(np.tile([0.0, 0.0, 0.025], (31, 1)), np.full(31, -0.2))
    hand = compose(small, [0.0, 0, 0.01, 0, 1, 0, 0])
    sizes = np.array([[0.03, 0.04, 0.04], [0.06, 0.045, 0.05]])
    shown = Demonstration(t, hand, np.stack([small, large], axis=1), ("a", "b"), sizes)
    plan = plan_film(Performance(shown, np.full(31, 0.06)), 320, 240, 10)
    path = tmp_path / "blues.mcap"
    write_recording(path, plan.camera.intrinsics, film(plan, Perception(), seed=1))
    seen = observe(path)
    d = seen.demonstration
    assert d.object_names == ("blue", "blue2")  # the larger one first
    np.testing.assert_allclose(np.sort(d.size_of("blue")[:2]), [0.045, 0.06], atol=0.003)  # a pixel
    np.testing.assert_allclose(d.size_of("blue2"), [0.03, 0.04, 0.04], atol=0.003)
    world_from_table = compose(plan.camera.world_from_camera, seen.camera_from_table)
    for name, real in (("blue", large), ("blue2", small)):
        away = np.linalg.norm(compose(world_from_table, d.pose_of(name))[:, :3] - real[:, :3], axis=1)
        assert np.median(away) < 0.002 and away.max() < 0.008


def _rewritten(filmed, path, change):
    recording = open_recording(filmed.path)
    frames = [change(k, frame) for k, frame in enumerate(recording.frames()) if k < 14]
    write_recording(path, recording.intrinsics, frames)
    return path


def test_hidden_objects_are_lost_not_made_up(filmed, tmp_path):
    def hide(k, frame):
        colour, depth = np.array(frame.colour), np.array(frame.depth)
        if k in (10, 11):  # a grey board before the lens
            colour[:], depth[:] = 128, 0.5
        return RgbdFrame(frame.t, colour, depth)

    seen = observe(_rewritten(filmed, tmp_path / "hidden.mcap", hide))
    assert seen.lost_frames == {"hand": 2, "blue": 2, "green": 2}
    t = seen.demonstration.t
    for k, name in enumerate(("hand", "blue", "green")):
        assert seen.lost[name] == ((t[10], t[11]),)
        assert list(np.flatnonzero(~seen.demonstration.seen(name))) == [10, 11]
        assert list(np.flatnonzero(seen.confidence[:, k] == 0)) == [10, 11]
    green = seen.demonstration.pose_of("green")
    np.testing.assert_allclose(green[12, :3], green[9, :3], atol=0.003)


def test_no_table_no_block_no_hand_are_said(filmed, tmp_path):
    def empty(_, frame):
        return RgbdFrame(frame.t, frame.colour, np.zeros_like(frame.depth))

    def bare(_, frame):
        return RgbdFrame(frame.t, np.full_like(frame.colour, 120), frame.depth)

    def gloveless(_, frame):
        red = frame.colour[..., 0].astype(int) > 1.5 * frame.colour[..., 2].astype(int)
        return RgbdFrame(frame.t, np.where(red[..., None], 120, frame.colour).astype(np.uint8), frame.depth)

    for name, change, words in (
        ("empty", empty, "only 0 pixels have a depth; a table cannot be found"),
        ("bare", bare, "in no frame are a red finger on the left and a yellow one on the right"),
        ("gloveless", gloveless, "in no frame are a red finger on the left and a yellow one on the right"),
    ):
        with pytest.raises(ImitateError, match=words):
            observe(_rewritten(filmed, tmp_path / f"{name}.mcap", change))


def test_missing_recording(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        observe(tmp_path / "none.mcap")


def test_without_open3d_one_line_says_what_to_install(filmed):
    script = (
        "import sys; sys.modules['open3d'] = None\n"
        "from imitate.cli import main\n"
        f"main(['observe', {str(filmed.path)!r}])"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert "pip install 'open3d-cpu==0.19.*' && sudo apt-get install -y libgl1" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_command_line(filmed, observed, tmp_path, capsys):
    output = tmp_path / "seen.npz"
    words = ["observe", str(filmed.path), "-o", str(output), "--json", "--seed", "3"]
    assert _exit(words) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["frames"] == len(observed.demonstration.t) and said["lost"] == {}
    assert [thing["name"] for thing in said["objects"]] == ["blue", "green"]
    written = read_demonstration(output)
    np.testing.assert_array_equal(written.hand, observed.demonstration.hand)
    before = output.read_bytes()
    assert _exit(words) == 1
    assert "exists already" in capsys.readouterr().err
    assert output.read_bytes() == before


def _exit(words):
    with pytest.raises(SystemExit) as end:
        main(words)
    return end.value.code or 0
