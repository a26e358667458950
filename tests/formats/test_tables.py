"""Columns of other people's files, with and without a mapping."""

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.spatial.transform import Rotation

from imitate.errors import DemonstrationError, FileError
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.kind import kind_of
from imitate.formats.mapping import Mapping, read_mapping

FRAMES = 5
T = np.arange(FRAMES) / 20
RNG = np.random.default_rng(0)
POSITIONS = {name: RNG.uniform(-0.3, 0.3, (FRAMES, 3)) for name in ("hand", "cube", "bin")}
TURNS = {name: Rotation.random(FRAMES, rng=RNG) for name in POSITIONS}
QUATERNIONS = {name: turn.as_quat() for name, turn in TURNS.items()}


def mapping(tmp_path: Path, text: str) -> Mapping:
    (tmp_path / "mapping.toml").write_text(text)
    return read_mapping(tmp_path / "mapping.toml")


def csv(path: Path, columns: dict[str, object], delimiter: str = ",") -> Path:
    rows = [list(columns), *zip(*columns.values(), strict=True)]
    path.write_text("".join(delimiter.join(map(str, row)) + "\n" for row in rows))
    return path


def named(pattern: str, turning: str, *bodies: str) -> dict[str, object]:
    columns: dict[str, object] = {}
    for body in bodies:
        columns |= {pattern.format(body, a): POSITIONS[body][:, k] for k, a in enumerate("xyz")}
        columns |= {turning.format(body, a): QUATERNIONS[body][:, k] for k, a in enumerate("xyzw")}
    return columns


@pytest.mark.parametrize(
    ("position", "rotation"),
    [
        ("{}_{}", "{}_q{}"),
        ("{}.position.{}", "{}.orientation.{}"),
        ("/mocap/{}/pose/position/{}", "/mocap/{}/pose/orientation/{}"),
        ("{}_pos_{}", "{}_quat_{}"),
        ("{} p{}", "{} q{}"),
    ],
)
def test_usual_names_are_recognised(tmp_path, position, rotation):
    columns = {"time": T, "note": ["a"] * FRAMES, **named(position, rotation, "hand", "cube")}
    read = read_demonstration(csv(tmp_path / "demo.csv", columns))
    assert read.object_names == ("cube",)
    np.testing.assert_array_equal(read.t, T)
    np.testing.assert_allclose(read.hand, np.hstack([POSITIONS["hand"], QUATERNIONS["hand"]]), atol=1e-15)
    np.testing.assert_allclose(read.objects[:, 0, 3:], QUATERNIONS["cube"], atol=1e-15)
    assert np.isnan(read.object_sizes).all()


OPENING = np.array([0.08, 0.07, np.nan, 0.04, 0.04])


@pytest.mark.parametrize("name", ["opening", "gripper_width", "gripper.opening", "Hand opening"])
def test_the_opening_is_recognised_by_its_name(tmp_path, name):
    columns = {"t": T, **named("{}_{}", "{}_q{}", "hand", "cube"), name: OPENING}
    read = read_demonstration(csv(tmp_path / "demo.csv", columns))
    assert read.object_names == ("cube",)
    np.testing.assert_array_equal(read.opening, OPENING)


def test_a_share_that_is_called_opening_is_no_distance(tmp_path):
    columns = {"t": T, **named("{}_{}", "{}_q{}", "hand", "cube"), "gripper_opening": np.linspace(0, 1, 5)}
    assert read_demonstration(csv(tmp_path / "demo.csv", columns)).opening is None


def test_the_opening_by_mapping_is_the_sum_of_each_fingers_way(tmp_path):
    poses = {f"obs/{name}": np.hstack([POSITIONS[name], QUATERNIONS[name]]) for name in ("hand", "cube")}
    with h5py.File(tmp_path / "demo.hdf5", "w") as file:
        for name, values in {**poses, "obs/qpos": np.outer(OPENING, [0.5, -0.5, 7])}.items():
            file[f"data/demo_0/{name}"] = values
    text = 'rate = 20.0\nopening = {}\n[hand]\npose = "obs/hand"\n[objects.cube]\npose = "obs/cube"\n'
    for said in ('"obs/qpos[0:2]"', '["obs/qpos[0]", "obs/qpos[1]"]'):
        read = read_demonstration(tmp_path / "demo.hdf5", mapping(tmp_path, text.format(said)))
        np.testing.assert_allclose(read.opening, OPENING)
    in_cm = mapping(tmp_path, 'length_unit = "cm"\n' + text.format('"obs/qpos[0:2]"'))
    np.testing.assert_allclose(read_demonstration(tmp_path / "demo.hdf5", in_cm).opening, OPENING / 100)
    with pytest.raises(FileError, match=r"has no column 'obs/fingers' \(for opening\); its columns are"):
        read_demonstration(tmp_path / "demo.hdf5", mapping(tmp_path, text.format('"obs/fingers"')))


def test_text_from_a_spreadsheet(tmp_path):
    file = csv(tmp_path / "demo.csv", {"t": T, **named("{}_{}", "{}_q{}", "hand", "cube")}, ";")
    file.write_text("\ufeff# exported\n" + file.read_text().replace(".", ",").replace("\n", "\r\n"))
    np.testing.assert_array_equal(read_demonstration(file).hand[:, :3], POSITIONS["hand"])


def test_an_empty_field_is_a_pose_not_seen_and_half_a_pose_is_an_error(tmp_path):
    columns = {"t": T, **named("{}_{}", "{}_q{}", "hand", "cube")}
    for name in list(columns)[8:]:
        columns[name] = ["", *columns[name][1:]]
    read = read_demonstration(csv(tmp_path / "demo.csv", columns))
    assert read.seen("cube").tolist() == [False, True, True, True, True]
    columns["hand_y"] = [*columns["hand_y"][:-1], ""]
    with pytest.raises(DemonstrationError, match=r"demo.csv: hand: NaN or infinite at frame 4"):
        read_demonstration(csv(tmp_path / "demo.csv", columns))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty. The first line names the columns"),
        ("1,2,3\n4,5,6\n", "has no header: its first line holds numbers"),
        ("t,hand_x,hand_x\n1,2,3\n", "names the column 'hand_x' twice"),
        ("# made by hand\nt,hand_x\n1,2\n3\n", "line 4 has 1 fields, its header 2"),
        ("t,x\n1,2\n", "names no object; its columns are t, x. Say what they mean in a mapping"),
        ("t,cube_x,cube_y,cube_z\n1,2,3,4\n", "names no hand; its columns are t, cube_x"),
    ],
)
def test_what_is_wrong_with_text_is_named(tmp_path, text, message):
    (tmp_path / "demo.csv").write_text(text)
    with pytest.raises(FileError) as caught:
        read_demonstration(tmp_path / "demo.csv")
    assert message in str(caught.value)


def test_a_word_among_numbers_is_found(tmp_path):
    columns = {"t": T, **named("{}_{}", "{}_q{}", "hand", "cube")}
    columns["cube_y"] = [0, 0, "lost", 0, 0]
    with pytest.raises(FileError, match=r"line 4, column cube_y: 'lost' is not a number"):
        read_demonstration(csv(tmp_path / "demo.csv", columns))


def test_times_are_needed(tmp_path):
    file = csv(tmp_path / "demo.csv", named("{}_{}", "{}_q{}", "hand", "cube"))
    with pytest.raises(FileError, match=r"has no column of times; .*rate = 20.0"):
        read_demonstration(file)
    read = read_demonstration(file, mapping(tmp_path, "rate = 20.0"))
    np.testing.assert_allclose(read.t, T)


def test_units_orders_offsets_and_sizes(tmp_path):
    columns: dict[str, object] = {"stamp": (T * 1e9).astype(int) + 17 * 10**17}
    columns |= {f"tool{a}": 1000 * POSITIONS["hand"][:, k] for k, a in enumerate("xyz")}
    columns |= {f"turn{a}": TURNS["hand"].as_rotvec()[:, k] for k, a in enumerate("xyz")}
    columns |= {f"block_{a}": 1000 * POSITIONS["cube"][:, k] for k, a in enumerate("xyz")}
    columns |= {f"block_q{a}": QUATERNIONS["cube"][:, k] for a, k in zip("wxyz", (3, 0, 1, 2), strict=True)}
    columns |= {f"tray_{a}": 1000 * POSITIONS["bin"][:, k] for k, a in enumerate("xyz")}
    said = mapping(
        tmp_path,
        """
        time = "stamp"
        time_unit = "ns"
        length_unit = "mm"
        rotation_as = "wxyz"
        [hand]
        position = ["toolx", "tooly", "toolz"]
        rotation = ["turnx", "turny", "turnz"]
        rotation_as = "rotvec"
        offset = [0, 0, 0.1]
        [objects.cube]
        pose = ["block_x", "block_y", "block_z", "block_qw", "block_qx", "block_qy", "block_qz"]
        size = [0.04, 0.04, 0.05]
        [objects.bin]
        position = ["tray_x", "tray_y", "tray_z"]
        """,
    )
    read = read_demonstration(csv(tmp_path / "demo.csv", columns), said)
    assert read.object_names == ("cube", "bin")
    np.testing.assert_allclose(read.t, T, atol=1e-6)
    shifted = POSITIONS["hand"] + TURNS["hand"].apply([0, 0, 0.1])
    np.testing.assert_allclose(read.hand[:, :3], shifted, atol=1e-12)
    np.testing.assert_allclose(
        (TURNS["hand"].inv() * Rotation.from_quat(read.hand[:, 3:])).magnitude(), 0, atol=1e-7
    )
    np.testing.assert_allclose(
        read.objects[:, 0], np.hstack([POSITIONS["cube"], QUATERNIONS["cube"]]), atol=1e-12
    )
    np.testing.assert_array_equal(read.objects[:, 1, 3:], np.tile([0, 0, 0, 1], (FRAMES, 1)))
    np.testing.assert_array_equal(read.object_sizes, [[0.04, 0.04, 0.05], [np.nan] * 3])


def lerobot(path: Path, episodes: int = 2) -> Path:
    state = np.hstack([POSITIONS["hand"], QUATERNIONS["hand"], POSITIONS["cube"], QUATERNIONS["cube"]])
    rows = [
        (e, T[k].astype(np.float32), (state[k] + (e and k)).astype(np.float32))
        for e in range(episodes)
        for k in range(FRAMES)
    ]
    pq.write_table(
        pa.table(
            {
                "observation.state": pa.array([row[2] for row in rows], pa.list_(pa.float32())),
                "timestamp": pa.array([row[1] for row in rows], pa.float32()),
                "episode_index": pa.array([row[0] for row in rows], pa.int64()),
                "observation.images.top": pa.array([{"bytes": b"", "path": ""} for _ in rows]),
            }
        ),
        path,
    )
    return path


BY_PARTS = """
episode = 0
[hand]
position = "observation.state[0:3]"
rotation = "observation.state[3:7]"
[objects.cube]
pose = "observation.state[7:14]"
"""
BY_NAMES = (
    "episode = 0\n[columns]\n'observation.state' = ["
    + ", ".join(f'"{b}_{a}"' for b in ("hand", "cube") for a in ("x", "y", "z", "qx", "qy", "qz", "qw"))
    + "]"
)


@pytest.mark.parametrize("text", [BY_PARTS, BY_NAMES])
def test_one_episode_of_a_list_column(tmp_path, text):
    file = lerobot(tmp_path / "file-000.parquet")
    assert kind_of(file) == "demonstration"
    read = read_demonstration(file, mapping(tmp_path, text))
    assert read.object_names == ("cube",)
    np.testing.assert_allclose(read.hand[:, :3], POSITIONS["hand"], atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(read.objects[:, 0, 3:], axis=1), 1, atol=1e-12)


def test_a_list_column_without_a_mapping_shows_one_to_start_from(tmp_path):
    file = lerobot(tmp_path / "episode.parquet", episodes=1)
    with pytest.raises(FileError) as caught:
        read_demonstration(file)
    message, shown = str(caught.value).split("One to start from:\n\n")
    assert "observation.state (14 numbers), timestamp" in message
    assert "observation.images.top (no numbers)" in message
    read = read_demonstration(file, mapping(tmp_path, shown))
    np.testing.assert_allclose(read.objects[:, 0, :3], POSITIONS["cube"], atol=1e-7)


def test_an_episode_is_chosen(tmp_path):
    file = lerobot(tmp_path / "file.parquet")
    with pytest.raises(FileError, match=r"holds 2 episodes, 0 to 1\. Choose one .*: episode = 0"):
        read_demonstration(file)
    with pytest.raises(FileError, match=r"holds 2 episodes, 0 to 1, and none of them is 7"):
        read_demonstration(file, mapping(tmp_path, "episode = 7"))


def robomimic(path: Path, demos: int = 2) -> Path:
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["env_args"] = '{"env_name": "Lift", "env_kwargs": {"control_freq": 20}}'
        for k in range(demos):
            obs = data.create_group(f"demo_{k}/obs")
            obs["robot0_eef_pos"] = POSITIONS["hand"] + k
            obs["robot0_eef_quat"] = QUATERNIONS["hand"]
            obs["object"] = np.hstack([POSITIONS["cube"], QUATERNIONS["cube"], POSITIONS["cube"]])
            obs["agentview_image"] = np.zeros((FRAMES, 4, 4, 3), np.uint8)
    return path


def test_robomimic(tmp_path):
    file = robomimic(tmp_path / "low_dim.hdf5")
    assert kind_of(file) == "demonstration"
    text = """
    episode = 1
    [hand]
    position = "obs/robot0_eef_pos"
    rotation = "obs/robot0_eef_quat"
    [objects.cube]
    pose = "obs/object[0:7]"
    """
    read = read_demonstration(file, mapping(tmp_path, text))
    np.testing.assert_allclose(read.t, T)
    np.testing.assert_array_equal(read.hand[:, :3], POSITIONS["hand"] + 1)
    np.testing.assert_allclose(read.objects[:, 0, 3:], QUATERNIONS["cube"], atol=1e-15)


def test_the_mapping_shown_for_robomimic_works(tmp_path):
    file = robomimic(tmp_path / "one.hdf5", 1)
    with pytest.raises(FileError) as caught:
        read_demonstration(file)
    shown = str(caught.value).split("One to start from:\n\n")[1]
    read = read_demonstration(file, mapping(tmp_path, shown))
    np.testing.assert_allclose(read.t, T)
    np.testing.assert_array_equal(read.objects[:, 0, :3], POSITIONS["cube"])


def test_robomimic_without_a_mapping(tmp_path):
    with pytest.raises(FileError, match=r"holds 2 demonstrations, demo_0 to demo_1\. Choose one"):
        read_demonstration(robomimic(tmp_path / "two.hdf5"))
    with pytest.raises(FileError) as caught:
        read_demonstration(robomimic(tmp_path / "one.hdf5", 1))
    assert "obs/object (10 numbers), obs/robot0_eef_pos (3 numbers)" in str(caught.value)
    assert 'position = "obs/robot0_eef_pos"\n    rotation = "obs/robot0_eef_quat"' in str(caught.value)


def test_damaged_hdf5(tmp_path):
    file = robomimic(tmp_path / "whole.hdf5")
    (tmp_path / "cut.hdf5").write_bytes(file.read_bytes()[:3000])
    with pytest.raises(FileError, match=r"cut.hdf5: cannot be read as HDF5"):
        read_demonstration(tmp_path / "cut.hdf5")


def test_arrays_of_other_names(tmp_path):
    np.savez(
        tmp_path / "mine.npz",
        ts=T,
        ee=np.hstack([POSITIONS["hand"], QUATERNIONS["hand"]]),
        obj=POSITIONS["cube"],
    )
    text = 'time = "ts"\n[hand]\npose = "ee"\n[objects.cube]\nposition = "obj"'
    read = read_demonstration(tmp_path / "mine.npz", mapping(tmp_path, text))
    np.testing.assert_array_equal(read.objects[:, 0, :3], POSITIONS["cube"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[hand]\nposition = "arm"', "has no column 'arm' (for hand); its columns are t, hand_x"),
        ('[hand]\nposition = "note"', "column 'note' (for hand) holds no numbers"),
        ('[hand]\npose = ["hand_x", "hand_y"]', "hand: hand_x, hand_y hold 2 numbers a row; expected 7"),
        ('[hand]\npose = "hand_x[0:7]"', "hand_x[0:7] (for hand): 'hand_x' holds 1 numbers a row"),
        ('[hand]\ntopic = "/hand"', "holds columns, and the mapping names a topic for hand"),
        ("[objects.ball]\nsize = [1, 1, 1]", "names no ball; its columns are"),
        ("episode = 3\n[columns]\nstate = ['a']", "has no column 'state' (in [columns])"),
    ],
)
def test_a_mapping_that_does_not_fit_the_file(tmp_path, text, message):
    columns = {"t": T, **named("{}_{}", "{}_q{}", "hand", "cube")}
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    np.savez(tmp_path / "demo.npz", **arrays, note=np.array(["a"] * FRAMES))
    with pytest.raises(FileError) as caught:
        read_demonstration(tmp_path / "demo.npz", mapping(tmp_path, text))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hand = ", "is not TOML"),
        ("quaternion = 'wxyz'", "quaternion: no such entry. Valid: time, time_unit, rate"),
        ("[hand]\npos = 'a'", "hand.pos: no such entry. Valid: pose, position"),
        ("rotation_as = 'zyx'", "rotation_as = 'zyx': Input should be 'xyzw', 'wxyz', 'rotvec' or 'rpy'"),
        ("[hand]\npose = 'a'\ntopic = 'b'", "hand: pose and topic both say where its poses are"),
        ("[hand]\nrotation = 'a'", "hand: rotation stands beside position"),
        ("[hand]\noffset = [1]", "hand: offset is x y z, or"),
        ("[hand]\noffset = [0, 0, 0, 1, 1, 0, 0]", "no unit quaternion"),
        ("[hand]\nsize = [1, 1, 1]", "hand.size: the hand has no size"),
        ("[objects.table]\npose = 'a'", "objects.table: this name is reserved"),
        ("[objects.a]\nsize = [1, 1]", "objects.a.size = [1, 1]: List should have at least 3 items"),
        ("time = 't'\nrate = 3", "time and rate both say when"),
    ],
)
def test_a_wrong_mapping(tmp_path, text, message):
    with pytest.raises(FileError) as caught:
        mapping(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'mapping.toml'}: ")
    assert message in str(caught.value)


def test_a_missing_mapping(tmp_path):
    with pytest.raises(FileError, match=r"none.toml: no such mapping file"):
        read_mapping(tmp_path / "none.toml")
