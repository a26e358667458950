"""Poses in an MCAP file, whoever wrote it: a track for each topic of poses and each frame of a tree.

Read are foxglove.PoseInFrame, FrameTransform and FrameTransforms in Protocol Buffers or JSON, and in ROS 2's
own encoding geometry_msgs/PoseStamped, PoseWithCovarianceStamped and TransformStamped and tf2_msgs/TFMessage.
The hand's opening is a number: std_msgs/Float64, Float32, Float64MultiArray, Float32MultiArray or
sensor_msgs/JointState, of several numbers the sum of their absolute values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.message import DecodeError

from imitate.demonstration import LONGEST_GAP
from imitate.errors import FileError
from imitate.formats.clock import ASTRAY, SECOND, Both, on_one_clock, unstamped
from imitate.formats.foxglove_message import foxglove_message
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.opening import is_opening
from imitate.formats.ros2 import Ros2Decoder
from imitate.formats.track import Track, Tracks
from imitate.geometry import nearly_normalised

Key = tuple[str, str]
"""whether a topic, a frame or a number, and its name."""
Sample = tuple[int, int, list[float]]
"""ns of its stamp, 0 where it has none, ns of the log, and a pose."""
_ROS2 = Ros2Decoder()


@dataclass(frozen=True)
class Samples:
    """Every pose and number of a file, as they were written.

    Attributes:
        rows: of each topic of poses, frame or topic of numbers.
        parents: the frame in which each is given.
        fixed: those that hold at all times.
    """

    path: Path
    rows: Mapping[Key, list[Sample]]
    parents: Mapping[Key, str]
    fixed: frozenset[Key]

    def tracks(self, clock: int, exactly: bool = False) -> Tracks:
        """Their tracks, by their stamps (``clock`` 0) or the log's times (1).

        A topic of numbers that has no stamps, or those of another clock, is placed by the log's times all the
        same, moved by what lies between the poses' stamps and the log.

        Args:
            clock: as above.
            exactly: keep samples whose times are off those around them.
        """
        poses = [self._taken(key) for key in self.rows if key[0] != "number"]
        behind = [stamp - logged for taken in poses for stamp, logged in taken if stamp]
        shift = round(median(behind)) if behind and not clock else 0
        found = {key: self._track(key, clock, shift, exactly) for key in self.rows}
        topics, frames, numbers = (
            {name: track for (is_a, name), track in found.items() if is_a == kind}
            for kind in ("topic", "frame", "number")
        )
        return Tracks(self.path, topics, frames, numbers)

    def _taken(self, key: Key) -> list[Both]:
        return [(stamp, logged) for stamp, logged, _ in self.rows[key]]

    def _track(self, key: Key, clock: int, shift: int, exactly: bool) -> Track:
        taken = self._taken(key)
        by_log = bool(clock) or (key[0] == "number" and _by_log(taken, shift))
        shift = shift if by_log and abs(shift) > ASTRAY * SECOND else 0
        timed = [(logged + shift if by_log else stamp, row) for stamp, logged, row in self.rows[key]]
        off: list[tuple[int, list[float]]] = []
        if not exactly:
            in_order = [timed[k] for k in sorted(range(len(taken)), key=lambda k: taken[k][1])]
            timed = list(on_one_clock(in_order, lambda one: one[0], off.append, SECOND))
        rows: dict[int, list[float]] = {}
        for time, row in timed:
            rows.setdefault(time, row)
        times = sorted(rows)
        poses = nearly_normalised([rows[time] for time in times])
        moved = bool(shift) or (by_log and not clock and not unstamped(taken))
        fixed, at = key in self.fixed, np.array(times, np.int64)
        return Track(self.parents[key], at, poses, fixed, taken, len(off), moved)


def _by_log(taken: list[Both], shift: int) -> bool:
    """Whether numbers have no stamps, or those of another clock than the log's moved by ``shift`` ns."""
    apart = median(stamp - logged - shift for stamp, logged in taken)
    return unstamped(taken) or abs(apart) > LONGEST_GAP * SECOND


def read_samples(reader: McapReader, opening: str | None = None) -> Samples:
    """Goes through the whole file; its ``metadata`` and ``damage`` are known afterwards.

    Args:
        reader: of the file.
        opening: the topic of the hand's opening; without it, those that are called so.

    Raises:
        FileError: a message that is not what its schema says.
    """
    found: dict[Key, list[Sample]] = {}
    parents: dict[Key, str] = {}
    fixed: set[Key] = set()
    for message in reader.messages():
        schema = (message.schema_name, message.encoding)
        read, kind = READERS.get(schema), "topic"
        if schema in NUMBERS and (message.topic == opening or (not opening and _says_opening(message))):
            read, kind = NUMBERS[schema], "number"
        if read is None:
            continue
        for frame, child, time, row in _decoded(reader.path, message, read):
            key = ("frame", _plain(child)) if child else (kind, message.topic)
            _check_parent(reader.path, key, parents.setdefault(key, _plain(frame)), _plain(frame))
            found.setdefault(key, []).append((time, message.time, row))
            if message.topic.endswith("tf_static"):
                fixed.add(key)
    return Samples(reader.path, found, parents, frozenset(fixed))


_Row = tuple[str, str, int, list[float]]  # frame, child frame, nanoseconds, pose


def _decoded(path: Path, message: RawMessage, read: Callable[[RawMessage], Iterator[_Row]]) -> list[_Row]:
    try:
        return list(read(message))
    except (DecodeError, ValueError, AttributeError) as error:
        problem = f"topic {message.topic} holds a message that is no {message.schema_name} ({error})"
        raise FileError(path, problem) from None


def _check_parent(path: Path, key: tuple[str, str], known: str, parent: str) -> None:
    if known != parent:
        raise FileError(
            path,
            f"gives {' '.join(key)} in several frames: {known!r} and {parent!r}",
            "A frame has one parent; a topic gives poses in one frame.",
        )


def _plain(frame: str) -> str:
    return frame.strip("/")


def _foxglove_pose(message: RawMessage) -> Iterator[_Row]:
    m = foxglove_message(PoseInFrame, message)
    yield m.frame_id, "", m.timestamp.ToNanoseconds(), _row(m.pose.position, m.pose.orientation)


def _foxglove_transform(message: RawMessage) -> Iterator[_Row]:
    yield _transform(foxglove_message(FrameTransform, message))


def _foxglove_transforms(message: RawMessage) -> Iterator[_Row]:
    yield from map(_transform, foxglove_message(FrameTransforms, message).transforms)


def _transform(m: FrameTransform) -> _Row:
    time = m.timestamp.ToNanoseconds()
    return m.parent_frame_id, m.child_frame_id, time, _row(m.translation, m.rotation)


def _ros2(message: RawMessage) -> Any:
    decoded = _ROS2.decode(message)
    if decoded is None:
        raise ValueError("it cannot be decoded by the definition that the file holds")
    return decoded


def _ros2_pose(message: RawMessage) -> Iterator[_Row]:
    m = _ros2(message)
    pose = m.pose.pose if hasattr(m.pose, "pose") else m.pose  # with its covariance, or without
    yield m.header.frame_id, "", _stamp(m.header), _row(pose.position, pose.orientation)


def _ros2_transform(message: RawMessage) -> Iterator[_Row]:
    yield _stamped(_ros2(message))


def _ros2_transforms(message: RawMessage) -> Iterator[_Row]:
    yield from map(_stamped, _ros2(message).transforms)


def _says_opening(message: RawMessage) -> bool:
    return is_opening(message.topic.rsplit("/", 1)[-1])


def _ros2_number(message: RawMessage) -> Iterator[_Row]:
    m = _ros2(message)
    stamped = hasattr(m, "position")  # joints, with a header
    values = m.position if stamped else np.atleast_1d(m.data)
    number = float(values[0]) if len(values) == 1 else float(np.abs(np.asarray(values)).sum())
    yield "", "", _stamp(m.header) if stamped else 0, [number, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def _stamped(m: Any) -> _Row:
    row = _row(m.transform.translation, m.transform.rotation)
    return m.header.frame_id, m.child_frame_id, _stamp(m.header), row


def _stamp(header: Any) -> int:
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def _row(p: Any, q: Any) -> list[float]:
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


READERS: dict[tuple[str, str], Callable[[RawMessage], Iterator[_Row]]] = {
    ("foxglove.PoseInFrame", "protobuf"): _foxglove_pose,
    ("foxglove.PoseInFrame", "json"): _foxglove_pose,
    ("foxglove.FrameTransform", "protobuf"): _foxglove_transform,
    ("foxglove.FrameTransform", "json"): _foxglove_transform,
    ("foxglove.FrameTransforms", "protobuf"): _foxglove_transforms,
    ("foxglove.FrameTransforms", "json"): _foxglove_transforms,
    ("geometry_msgs/msg/PoseStamped", "cdr"): _ros2_pose,
    ("geometry_msgs/msg/PoseWithCovarianceStamped", "cdr"): _ros2_pose,
    ("geometry_msgs/msg/TransformStamped", "cdr"): _ros2_transform,
    ("tf2_msgs/msg/TFMessage", "cdr"): _ros2_transforms,
}
"""(schema, encoding) → how its poses are read."""
NUMBERS: dict[tuple[str, str], Callable[[RawMessage], Iterator[_Row]]] = {
    (f"{kind[0]}_msgs/msg/{kind[1]}", "cdr"): _ros2_number
    for kind in (
        ("std", "Float64"),
        ("std", "Float32"),
        ("std", "Float64MultiArray"),
        ("std", "Float32MultiArray"),
        ("sensor", "JointState"),
    )
}
"""the same of numbers."""
