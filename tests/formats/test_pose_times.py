"""Poses of an MCAP file by one clock: stamps that are missing, off or of another clock, and what is said."""

from pathlib import Path

import numpy as np
import pytest
from mcap_ros2.writer import Writer as Ros2Writer
from test_tracks import JOINTS, POSE_STAMPED, TF, pose, xyz

from imitate.demonstration import Demonstration
from imitate.errors import ImitateError
from imitate.formats.demonstrations import read_demonstration

REPORTS = Path(__file__).parents[3] / "shared" / "data" / "reports"
T = np.arange(0, 3, 0.05)
START = 1_700_000_000
Message = tuple[str, str, float, float, object]
"""topic, kind, seconds of its stamp, seconds of the log, what it holds."""


def bag(path: Path, messages: list[Message]) -> Path:
    with path.open("wb") as stream:
        writer = Ros2Writer(stream)
        schemas = {
            "pose": writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE_STAMPED),
            "tf": writer.register_msgdef("tf2_msgs/msg/TFMessage", TF),
            "number": writer.register_msgdef("std_msgs/msg/Float32", "float32 data"),
            "joints": writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS),
        }
        for topic, kind, stamp, logged, held in messages:
            head = {"stamp": _stamp(stamp), "frame_id": "world"}
            message = {"data": held} if kind == "number" else {"header": head, **held}
            writer.write_message(topic, schemas[kind], message, round(logged * 1e9), round(logged * 1e9))
        writer.finish()
    return path


def _stamp(seconds: float) -> dict[str, int]:
    nanoseconds = round(seconds * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def poses(body: str, stamps: np.ndarray, logged: np.ndarray | None = None) -> list[Message]:
    """A body's motion over `T`, stamped and logged as said."""
    found = []
    for t, stamp, log in zip(T, stamps, START + T if logged is None else logged, strict=True):
        p = pose(body, t)
        held = {"pose": {"position": xyz(p[:3]), "orientation": xyz(p[3:], "xyzw")}}
        found.append((f"/{body}/pose", "pose", stamp, log, held))
    return found


def read(path: Path, messages: list[Message]) -> tuple[Demonstration, list[str]]:
    notes: list[str] = []
    return read_demonstration(bag(path, messages), None, notes), notes


def shown(read: Demonstration, frames: object = slice(None)) -> bool:
    """Whether hand and cube are together what they were at those times."""
    np.testing.assert_allclose(read.t - read.t[0], T[frames] - T[frames][0], atol=2e-6)
    np.testing.assert_allclose(read.hand, [pose("hand", t) for t in T[frames]], atol=1e-9)
    np.testing.assert_allclose(read.pose_of("cube"), [pose("cube", t) for t in T[frames]], atol=1e-6)
    return True


def test_stamps_of_one_clock_are_used_without_a_word(tmp_path):
    found, notes = read(tmp_path / "a.mcap", poses("hand", START + T) + poses("cube", START + T))
    assert shown(found)
    assert notes == []


@pytest.mark.parametrize(
    ("hand", "cube", "why"),
    [
        (START + T, 1 + T, "hand, cube are stamped by two clocks, 19,676 days apart"),
        (START + T, 0 * T, "cube has no stamps"),
        (0 * T, START + T, "hand has no stamps"),
        (0 * T, 0 * T, "hand, cube have no stamps"),
    ],
)
def test_where_stamps_are_missing_or_of_two_clocks_the_log_counts_for_all(tmp_path, hand, cube, why):
    found, notes = read(tmp_path / "a.mcap", poses("hand", hand) + poses("cube", cube))
    assert shown(found)
    assert found.t[0] == START
    assert notes == [f"{why}: the log's times are used"]


def test_two_clocks_that_nothing_relates_are_named(tmp_path):
    file = bag(tmp_path / "a.mcap", poses("hand", START + T, START + T) + poses("cube", 1 + T, 1 + T))
    with pytest.raises(ImitateError) as caught:
        read_demonstration(file)
    assert str(caught.value) == (
        f"{file}: mixes two clocks: the hand is stamped 1700000000.000 to 1700000002.950 s, cube 1.000 to "
        "3.950 s, and the log's times do not relate them. Record both by one clock, or name the objects to "
        "read in a mapping (--mapping FILE.toml)."
    )


@pytest.mark.parametrize("by", [-30, 30, -START])
@pytest.mark.parametrize("at", [0, 20, len(T) - 1])
def test_a_pose_whose_stamp_is_off_is_left_out_and_said(tmp_path, at, by):
    off = START + T
    off[at] += by
    found, notes = read(tmp_path / "a.mcap", poses("hand", off) + poses("cube", START + T))
    assert shown(found, np.arange(len(T)) != at)
    assert notes == ["1 of 60 poses of hand is left out: stamped more than 1 s off those before and after"]
    found, notes = read(tmp_path / "b.mcap", poses("hand", START + T) + poses("cube", off))
    seen = found.seen("cube")  # between its neighbours, or held beyond its last one
    assert seen.sum() >= len(T) - 1
    expected = np.array([pose("cube", t) for t in T])
    np.testing.assert_allclose(found.pose_of("cube")[seen], expected[seen], atol=0.03)
    assert notes == ["1 of 60 poses of cube is left out: stamped more than 1 s off those before and after"]


def test_where_many_are_off_none_is_believed(tmp_path):
    off = np.where(np.arange(len(T)) % 5 == 4, START + T - 30, START + T)
    file = bag(tmp_path / "a.mcap", poses("hand", START + T) + poses("cube", off))
    with pytest.raises(
        ImitateError, match=r"12 of 60 poses of cube are more than 1 s off those around\. Record"
    ):
        read_demonstration(file)


def test_a_day_s_pause_is_named_and_a_short_one_is_said(tmp_path):
    day = START + T + np.where(T > 1, 86400, 0)
    file = bag(tmp_path / "day.mcap", poses("hand", day, day) + poses("cube", day, day))
    with pytest.raises(ImitateError, match=r"t: 24 hours pass without a frame, from 1 s after the first"):
        read_demonstration(file)
    short = START + T + np.where(T > 1, 20, 0)
    _, notes = read(tmp_path / "short.mcap", poses("hand", short, short) + poses("cube", short, short))
    assert notes[0].startswith("20.05 s pass without a frame, from 1 s on: taken as one straight motion")


WIDTH = 0.08 - 0.02 * T


def opening(kind: str, stamps: np.ndarray, topic: str = "/gripper/opening") -> list[Message]:
    held = [{"name": ["a"], "position": [w], "velocity": [], "effort": []} for w in WIDTH]
    values = list(WIDTH) if kind == "number" else held
    return [(topic, kind, s, log, v) for s, log, v in zip(stamps, START + T, values, strict=True)]


@pytest.mark.parametrize(
    ("clock", "kind", "stamps", "said"),
    [
        (START, "number", 0 * T, False),
        (START, "joints", START + T, False),
        (1, "number", 0 * T, True),
        (1, "joints", 1 + T, False),
        (START, "joints", 1 + T, True),
        (1, "joints", START + 86400 + T, True),
        (START, "joints", 0 * T, False),
    ],
)
def test_the_opening_is_placed_whatever_its_clock(tmp_path, clock, kind, stamps, said):
    messages = poses("hand", clock + T) + poses("cube", clock + T) + opening(kind, stamps)
    found, notes = read(tmp_path / "a.mcap", messages)
    assert found.t[0] == clock
    np.testing.assert_allclose(found.opening, WIDTH, atol=1e-6)
    words = "has no stamps of the poses' clock: it is placed by the log's times"
    assert notes == ([f"the opening in /gripper/opening {words}"] if said else [])


def test_an_opening_of_no_time_of_the_hand_s_is_said_to_be_left_out(tmp_path):
    late = [(topic, kind, 0.0, log + 50, v) for topic, kind, _, log, v in opening("number", T)]
    found, notes = read(tmp_path / "a.mcap", poses("hand", START + T) + poses("cube", START + T) + late)
    assert found.opening is None
    assert notes == [
        "the opening in /gripper/opening is of no time at which the hand was seen, and is left out"
    ]


def test_of_two_openings_it_is_said_which_is_taken(tmp_path):
    both = opening("number", 0 * T, "/a/opening") + opening("number", 0 * T, "/b/opening")
    _, notes = read(tmp_path / "a.mcap", poses("hand", START + T) + poses("cube", START + T) + both)
    assert notes == ["the opening is taken from /a/opening, not from /b/opening (opening in a mapping)"]


def test_a_quaternion_of_nearly_length_one_is_one_here_too(tmp_path):
    messages = poses("hand", START + T) + poses("cube", START + T)
    for message in messages:
        turned = message[4]["pose"]["orientation"]
        message[4]["pose"]["orientation"] = {axis: 0.995 * value for axis, value in turned.items()}
    assert shown(read(tmp_path / "a.mcap", messages)[0])


@pytest.mark.skipif(not REPORTS.exists(), reason="the shared reports are not here")
def test_a_file_of_two_clocks_that_someone_brought_is_read():
    notes: list[str] = []
    found = read_demonstration(REPORTS / "objects_by_another_clock.mcap", None, notes)
    assert found.seen("a").all()
    assert notes == ["hand, a, b are stamped by two clocks, 19,676 days apart: the log's times are used"]
