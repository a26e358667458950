"""Poses in an MCAP file, whoever wrote it: a track for each topic of poses and each frame of a tree.

Read are foxglove.PoseInFrame, FrameTransform and FrameTransforms in Protocol Buffers, and in ROS 2's own
encoding geometry_msgs/PoseStamped, PoseWithCovarianceStamped and TransformStamped and tf2_msgs/TFMessage. The
hand's opening is a number: std_msgs/Float64, Float32, Float64MultiArray, Float32MultiArray or
sensor_msgs/JointState, of several numbers the sum of their absolute values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.opening import is_opening
from imitate.formats.ros2 import Ros2Decoder
from imitate.geometry import Array, compose, nearly_normalised, relative, resample

GAP = 5.0
"""times a track's usual step; what lies between samples further apart was not seen."""
SHORTEST_GAP = 0.2
"""s; and no shorter than this."""

Times = NDArray[np.int64]
_ROS2 = Ros2Decoder()


@dataclass(frozen=True)
class Track:
    """Poses of one body over time.

    Attributes:
        frame: that they are given in.
        times: (N,) nanoseconds, strictly increasing.
        poses: (N, 7).
        fixed: whether they hold at all times.
    """

    frame: str
    times: Times
    poses: Array
    fixed: bool = False

    def at(self, times: Times) -> Array:
        """(S, 7) poses at other times: interpolated, and seven NaN in a gap or beyond the track's ends."""
        if self.fixed or len(self.times) == 1:
            return np.repeat(self.poses[-1:], len(times), axis=0)
        step = float(np.median(np.diff(self.times)))
        gap = max(GAP * step, SHORTEST_GAP * 1e9)
        after = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        apart = self.times[after] - self.times[after - 1]
        beyond = np.maximum(self.times[0] - times, times - self.times[-1])
        met = np.isin(times, self.times)
        origin = self.times[0]
        found = resample((self.times - origin) / 1e9, self.poses, (times - origin) / 1e9)
        exact = self.poses[np.minimum(np.searchsorted(self.times, times), len(self.times) - 1)]
        found[met] = exact[met]
        found[~met & ((apart > gap) | (beyond > step))] = np.nan
        return found


@dataclass(frozen=True)
class Tracks:
    """Every track of a file.

    Attributes:
        topics: topic → track, of topics that give poses.
        frames: frame → track in its parent frame, of transforms.
        numbers: topic → track whose positions' x it is, of numbers that may be the hand's opening.
    """

    path: Path
    topics: Mapping[str, Track]
    frames: Mapping[str, Track]
    numbers: Mapping[str, Track]

    def times(self, source: Track) -> Times:
        """Of the link with the most samples, from a track up to the root of its frames."""
        return max((link.times for link in self._links(source)), key=len)

    def top(self, source: Track) -> str:
        """The frame at the root of a track's frames."""
        return list(self._links(source))[-1].frame

    def within(self, source: Track, root: str, times: Times) -> Array:
        """(S, 7) a track's poses in the frame ``root``.

        Raises:
            FileError: no transform leads there.
        """
        poses, frame = source.at(times), source.frame
        while frame != root and frame in self.frames:
            poses, frame = compose(self.frames[frame].at(times), poses), self.frames[frame].frame
        if frame == root:
            return poses
        if root in self.frames and self.top(self.frames[root]) == frame:
            return relative(self.within(self.frames[root], frame, times), poses)
        raise FileError(
            self.path,
            f"gives poses in several frames, and no transform leads from {source.frame!r} to {root!r}",
            "Record the transforms as well, or give all in one frame.",
        )

    def _links(self, source: Track) -> Iterator[Track]:
        for _ in range(len(self.frames) + 1):
            yield source
            if source.frame not in self.frames:
                return
            source = self.frames[source.frame]
        raise FileError(self.path, f"has transforms in a circle through {source.frame!r}")


def read_tracks(reader: McapReader, opening: str | None = None) -> Tracks:
    """Goes through the whole file; its ``metadata`` and ``damage`` are known afterwards.

    Args:
        opening: the topic of the hand's opening; without it, those that are called so.

    Raises:
        FileError: a message that is not what its schema says.
    """
    found: dict[tuple[str, str], dict[int, list[float]]] = {}
    parents: dict[tuple[str, str], str] = {}
    fixed: set[tuple[str, str]] = set()
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
            found.setdefault(key, {}).setdefault(time or message.time, row)
            if message.topic.endswith("tf_static"):
                fixed.add(key)
    tracks = {key: _track(parents[key], rows, key in fixed) for key, rows in found.items()}
    topics, frames, numbers = (
        {name: track for (is_a, name), track in tracks.items() if is_a == kind}
        for kind in ("topic", "frame", "number")
    )
    return Tracks(reader.path, topics, frames, numbers)


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


def _track(frame: str, rows: dict[int, list[float]], fixed: bool) -> Track:
    times = sorted(rows)
    poses = nearly_normalised([rows[time] for time in times])
    return Track(frame, np.array(times, np.int64), poses, fixed)


def _plain(frame: str) -> str:
    return frame.strip("/")


def _foxglove_pose(message: RawMessage) -> Iterator[_Row]:
    m = PoseInFrame.FromString(message.data)
    yield m.frame_id, "", m.timestamp.ToNanoseconds(), _row(m.pose.position, m.pose.orientation)


def _foxglove_transform(message: RawMessage) -> Iterator[_Row]:
    yield _transform(FrameTransform.FromString(message.data))


def _foxglove_transforms(message: RawMessage) -> Iterator[_Row]:
    yield from map(_transform, FrameTransforms.FromString(message.data).transforms)


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
    yield "", "", _stamp(m.header) if stamped else message.time, [number, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def _stamped(m: Any) -> _Row:
    row = _row(m.transform.translation, m.transform.rotation)
    return m.header.frame_id, m.child_frame_id, _stamp(m.header), row


def _stamp(header: Any) -> int:
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def _row(p: Any, q: Any) -> list[float]:
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


READERS: dict[tuple[str, str], Callable[[RawMessage], Iterator[_Row]]] = {
    ("foxglove.PoseInFrame", "protobuf"): _foxglove_pose,
    ("foxglove.FrameTransform", "protobuf"): _foxglove_transform,
    ("foxglove.FrameTransforms", "protobuf"): _foxglove_transforms,
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
