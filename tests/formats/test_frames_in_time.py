"""Times of tables: units, stamps that are off, episodes, clocks that were set; and what is said of them."""

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from imitate.demonstration import Demonstration
from imitate.errors import ImitateError
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.mapping import Mapping
from imitate.formats.table import columns_of
from imitate.geometry import from_yaw

REPORTS = Path(__file__).parents[3] / "shared" / "data" / "reports"
T = np.arange(0, 6, 0.1)
EPOCH = 1_700_000_000
SHOWN = Demonstration(
    t=T,
    hand=from_yaw(np.outer(T, [0.1, 0.2, 0]), T / 9),
    objects=from_yaw(np.outer(T, [0, 0, 0.05]), 0 * T)[:, None],
    object_names=("cube",),
    object_sizes=np.full((1, 3), 0.04),
    opening=np.linspace(0.08, 0.02, len(T)),
)


def write(path: Path, t: np.ndarray, times: int = 1, **more: np.ndarray) -> Path:
    """The demonstration with other times, ``times`` over, in the format that the suffix names."""
    if path.suffix == ".npz":
        poses = {
            name: np.concatenate([getattr(SHOWN, name)] * times) for name in ("hand", "objects", "opening")
        }
        named = {"object_names": np.array(SHOWN.object_names), "object_sizes": SHOWN.object_sizes}
        np.savez(path, t=t, **poses, **named, **more)
        return path
    columns = {name: np.concatenate([np.asarray(v)] * times) for name, v in columns_of(SHOWN).items()}
    columns |= {"t": np.asarray(t), **more}
    if path.suffix == ".csv":
        rows = [columns, *zip(*(column.tolist() for column in columns.values()), strict=True)]
        path.write_text("".join(",".join(map(str, row)) + "\n" for row in rows))
    elif path.suffix == ".parquet":
        pq.write_table(pa.table(columns), path)
    else:
        with h5py.File(path, "w") as file:
            for name, values in columns.items():
                file[name] = values
    return path


FORMATS = pytest.mark.parametrize("suffix", [".npz", ".csv", ".parquet", ".h5"])


def same(read: Demonstration, frames: object = slice(None)) -> bool:
    """Whether those frames of what was shown were read, whenever they start."""
    np.testing.assert_allclose(read.t - read.t[0], T[frames] - T[frames][0], atol=2e-6)
    np.testing.assert_array_equal(read.hand, SHOWN.hand[frames])
    np.testing.assert_array_equal(read.objects, SHOWN.objects[frames])
    np.testing.assert_array_equal(read.opening, SHOWN.opening[frames])
    return True


@FORMATS
@pytest.mark.parametrize(
    ("unit", "name"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
)
def test_times_since_1970_are_known_and_said(tmp_path, suffix, unit, name):
    file = write(tmp_path / f"demo{suffix}", np.round((T + EPOCH) * unit).astype(np.int64))
    notes: list[str] = []
    assert same(read_demonstration(file, None, notes))
    assert notes == [
        f"its times are {name} since 1970 and read as such; time_unit in a mapping says otherwise"
    ]


@FORMATS
def test_seconds_are_kept_as_they_are(tmp_path, suffix):
    notes: list[str] = []
    for k, t in enumerate((T, T + EPOCH, T - 5, np.round(T) + EPOCH + T / 1e3)):
        read = read_demonstration(write(tmp_path / f"{k}{suffix}", t), None, notes)
        np.testing.assert_array_equal(read.t, t)
    assert notes == []


def refused(file: Path, **said: object) -> str:
    with pytest.raises(ImitateError) as caught:
        read_demonstration(file, Mapping(**said) if said else None)
    assert str(caught.value).startswith(f"{file}: ")
    return str(caught.value).removeprefix(f"{file}: ")


@FORMATS
def test_other_units_are_asked_for(tmp_path, suffix):
    ms = write(tmp_path / f"ms{suffix}", np.round(1e3 * T))
    assert refused(ms) == (
        "has times that are no seconds of a demonstration: 60 of them, usually 100 apart. Say their unit in "
        'a mapping (--mapping FILE.toml): time_unit = "ms", if they are milliseconds; or "s", if they are '
        "seconds after all."
    )
    assert same(read_demonstration(ms, Mapping(time_unit="ms")))
    uptime = write(tmp_path / f"us{suffix}", 1e6 * T + 5e9 + 0.5)
    assert 'time_unit = "us", if they are microseconds' in refused(uptime)
    assert same(read_demonstration(uptime, Mapping(time_unit="us")))


def test_numbers_of_frames_are_no_seconds(tmp_path):
    counted = write(tmp_path / "frames.npz", np.arange(60))
    assert "usually 1 apart" in refused(counted)
    assert "rate = 30.0, if they count frames" in refused(counted)
    assert same(read_demonstration(counted, Mapping(rate=10)))
    slow = read_demonstration(counted, Mapping(time_unit="s"))
    np.testing.assert_array_equal(slow.t, np.arange(60))


def test_times_without_the_precision_for_them(tmp_path):
    single = write(tmp_path / "single.npz", (T + EPOCH).astype(np.float32))
    assert "has the same time in most of its frames: 1 times in 60. Times since 1970 need double" in refused(
        single
    )
    assert same(read_demonstration(single, Mapping(rate=10)))


@FORMATS
@pytest.mark.parametrize("at", [0, 30, 59])
@pytest.mark.parametrize("by", [-30.0, 30.0, 1e9])
def test_a_frame_whose_stamp_is_off_is_left_out_and_said(tmp_path, suffix, at, by):
    off = T.copy()
    off[at] += by
    notes: list[str] = []
    assert same(read_demonstration(write(tmp_path / f"demo{suffix}", off), None, notes), np.arange(60) != at)
    assert notes == [
        "1 of 60 frames is left out: stamped more than 1 s off those before and after "
        f"(frame {at}, at {off[at]:.12g} s)"
    ]


def test_where_many_are_off_none_is_believed(tmp_path):
    off = np.where(np.arange(60) % 5 == 4, T - 30, T)
    assert refused(write(tmp_path / "demo.npz", off)) == (
        "12 of its 60 times are more than 1 s off those before and after. Mend them, or say the frames a "
        "second in a mapping (--mapping FILE.toml): rate = 30.0."
    )


@FORMATS
def test_a_long_gap_is_named_and_each_side_of_it_can_be_read(tmp_path, suffix):
    day = write(tmp_path / f"day{suffix}", np.where(T > 2, T + 86400, T))
    assert refused(day) == (
        "has times that jump by 24 hours at frame 21, from 2 s to 86402.1 s: its clock was set, or it goes "
        "on another time. Read one part in a mapping (--mapping FILE.toml): episode = 0, the first of 2."
    )
    if suffix != ".h5":  # there an episode is a group
        assert same(read_demonstration(day, Mapping(episode=0)), slice(0, 21))
        assert same(read_demonstration(day, Mapping(episode=1)), slice(21, None))
        assert "holds 2 episodes, 0 to 1, and none of them is 2" in refused(day, episode=2)


def test_a_pause_is_said(tmp_path):
    notes: list[str] = []
    read = read_demonstration(write(tmp_path / "pause.npz", np.where(T > 2, T + 30, T)), None, notes)
    assert len(read.t) == 60
    assert notes[0].startswith("30.1 s pass without a frame, from 2 s on: taken as one straight motion")


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".parquet"])
def test_times_that_start_again_are_episodes(tmp_path, suffix):
    two = write(tmp_path / f"two{suffix}", np.concatenate([T, T]), 2)
    assert refused(two) == (
        "seems to hold 2 episodes: its times start again at frame 60, from 5.9 s to 0 s. Read one part in a "
        "mapping (--mapping FILE.toml): episode = 0, the first of 2."
    )
    assert same(read_demonstration(two, Mapping(episode=1)))
    back = write(tmp_path / f"back{suffix}", np.where(T > 4, T - 2.5, T))
    assert "has times that go back by 2.4 s at frame 41, from 4 s to 1.6 s: its clock was set" in refused(
        back
    )


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@pytest.mark.parametrize("name", ["episode_index", "Episode"])
def test_an_episode_of_a_column_is_chosen(tmp_path, suffix, name):
    file = write(tmp_path / f"two{suffix}", np.concatenate([T, T]), 2, **{name: np.repeat([3, 7], 60)})
    assert refused(file) == (
        "holds 2 episodes, 3 to 7. Choose one in a mapping (--mapping FILE.toml): episode = 3."
    )
    assert same(read_demonstration(file, Mapping(episode=7)))
    assert "holds 2 episodes, 3 to 7, and none of them is 0" in refused(file, episode=0)
    rated = read_demonstration(file, Mapping(episode=7, rate=10))
    np.testing.assert_allclose(rated.t, T)


def test_what_is_in_no_order_is_not_taken_for_episodes(tmp_path):
    shuffled = np.random.default_rng(0).permutation(T)
    assert "expected strictly increasing times. Sort the frames." in refused(
        write(tmp_path / "a.npz", shuffled)
    )
    twice = np.append(T[:-1], T[-2])
    assert "at frame 59; expected strictly increasing times. Remove rep" in refused(
        write(tmp_path / "b.npz", twice)
    )
    missing = np.append(T[:-1], np.nan)
    assert "t: not a number at frame 59" in refused(write(tmp_path / "c.npz", missing))


def test_a_mapping_serves_our_own_arrays(tmp_path):
    own = write(tmp_path / "own.npz", T)
    assert same(read_demonstration(own, Mapping(time_unit="s")))
    small = read_demonstration(own, Mapping(length_unit="mm", objects={"cube": {"size": [0.1, 0.2, 0.3]}}))
    np.testing.assert_allclose(small.hand[:, :3], SHOWN.hand[:, :3] / 1000)
    np.testing.assert_array_equal(small.object_sizes, [[0.1, 0.2, 0.3]])


def test_a_quaternion_is_as_near_to_one_in_every_format(tmp_path):
    for suffix in (".npz", ".csv", ".parquet", ".h5"):
        for length, taken in ((0.995, True), (0.985, False)):
            rows = np.array(SHOWN.hand)
            rows[:, 3:] *= length
            file = tmp_path / f"{length}{suffix}"
            columns = columns_of(SHOWN) | {f"hand_q{a}": rows[:, 3 + k] for k, a in enumerate("xyzw")}
            if suffix == ".npz":
                write(file, T)
                held = dict(np.load(file))
                np.savez(file, **(held | {"hand": rows}))
            else:
                extra = {name: column for name, column in columns.items() if name.startswith("hand_q")}
                write(file, T, **extra)
            if taken:
                np.testing.assert_allclose(read_demonstration(file).hand, SHOWN.hand, atol=1e-12)
            else:
                assert "hand: quaternion of length 0.985 at frame 0" in refused(file)


@pytest.mark.skipif(not REPORTS.exists(), reason="the shared reports are not here")
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("clock_set_in_the_middle.csv", "jump by 19,676 days at frame 30, from 102.9 s to 1700000103 s"),
        ("two_episodes.csv", "holds 2 episodes, 0 to 1. Choose one in a mapping"),
    ],
)
def test_files_that_people_brought_are_answered(name, words):
    assert words in refused(REPORTS / name)
    assert len(read_demonstration(REPORTS / name, Mapping(episode=1)).t) > 10


@pytest.mark.skipif(not REPORTS.exists(), reason="the shared reports are not here")
@pytest.mark.parametrize(
    ("name", "said"),
    [("milliseconds.csv", "its times are milliseconds since 1970"), ("quaternion_length_0.995.npz", "")],
)
def test_files_that_people_brought_are_read(name, said):
    notes: list[str] = []
    assert read_demonstration(REPORTS / name, None, notes).duration == pytest.approx(6)
    assert " ".join(notes).startswith(said)
