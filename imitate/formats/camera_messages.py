"""What cameras send: Foxglove's messages in Protocol Buffers and ROS 2's in CDR, made one of a kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats import pictures
from imitate.formats.clouds import unpacked_colour
from imitate.formats.foxglove_message import foxglove_message
from imitate.formats.mcap_file import RawMessage
from imitate.formats.registration import Lens
from imitate.formats.ros2 import Ros2Decoder
from imitate.geometry import Array, normalised
from imitate.rgbd import Intrinsics

_FOXGLOVE: dict[str, Any] = {
    kind.DESCRIPTOR.full_name: kind
    for kind in (CameraCalibration, CompressedImage, RawImage, PointCloud, FrameTransform, FrameTransforms)
}
CALIBRATIONS = frozenset({"foxglove.CameraCalibration", "sensor_msgs/msg/CameraInfo"})
TRANSFORMS = frozenset({"foxglove.FrameTransform", "foxglove.FrameTransforms", "tf2_msgs/msg/TFMessage"})
_BANDS = {1: "u1", 2: "i1", 3: "u2", 4: "i2", 5: "u4", 6: "i4", 7: "f4", 8: "f8"}
"""foxglove.PackedElementField's numbers of types."""
_ROS_BANDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""sensor_msgs/PointField's."""


@dataclass(frozen=True)
class Picture:
    """A picture, decoded when asked.

    Attributes:
        time: nanoseconds, its own stamp; 0 in recordings that do not stamp.
        frame: name of the camera's frame.
        form: its encoding, in words.
        decode: its pixels as in `imitate.formats.pictures`; None where they cannot be decoded.
    """

    time: int
    frame: str
    form: str
    decode: Callable[[], pictures.Pixels | None]


@dataclass(frozen=True)
class Cloud:
    """As a picture's pixels: points (H, W, 3) metres, colour (H, W, 3) or None; time as in a picture."""

    time: int
    frame: str
    points: NDArray[np.float32]
    colour: NDArray[np.uint8] | None


@dataclass(frozen=True)
class Calibration:
    """A lens, the frame it is in, and the same lens after rectification."""

    frame: str
    lens: Lens
    rectified: Lens


@dataclass(frozen=True)
class Transform:
    """Where the child's frame is in its parent's: pose (7,)."""

    parent: str
    child: str
    pose: Array


@dataclass
class CameraReader:
    """Reads the messages of one file.

    Raises (each method):
        FileError: a message that is not what its schema says, or in an encoding that is not known.
    """

    path: Path
    _ros: Ros2Decoder = field(default_factory=Ros2Decoder)

    def picture(self, message: RawMessage) -> Picture:
        """A picture of any of the schemas `PICTURES`."""
        m = self._message(message)
        time, frame = _stamp(m), _frame(m)
        if message.schema_name.endswith("CompressedImage"):
            data, form = bytes(m.data), m.format
            return Picture(time, frame, form, lambda: pictures.compressed(form, data))
        big = bool(getattr(m, "is_bigendian", False))
        raw = (m.encoding, m.width, m.height, m.step, bytes(m.data), big)
        return Picture(time, frame, m.encoding, lambda: pictures.raw(*raw))

    def calibration(self, message: RawMessage) -> Calibration:
        """A calibration of any of the schemas `CALIBRATIONS`."""
        m = self._message(message)
        k, d, p = (list(getattr(m, n if hasattr(m, n) else n.lower())) for n in "KDP")
        if len(k) != 9 or k[0] <= 0 or k[4] <= 0:
            raise FileError(self.path, f"{message.topic} calibrates no camera: K is {k}", _UNCALIBRATED)
        plain = Intrinsics(m.width, m.height, k[0], k[4], k[2], k[5])
        straight = Lens(Intrinsics(m.width, m.height, p[0], p[5], p[2], p[6])) if any(p) else Lens(plain)
        return Calibration(_frame(m), Lens(plain, m.distortion_model, tuple(d)), straight)

    def transforms(self, message: RawMessage) -> list[Transform]:
        """Transforms of any of the schemas `TRANSFORMS`."""
        m = self._message(message)
        if message.schema_name == "foxglove.FrameTransform":
            return [_transform(m.parent_frame_id, m.child_frame_id, m)]
        if message.schema_name == "foxglove.FrameTransforms":
            return [_transform(one.parent_frame_id, one.child_frame_id, one) for one in m.transforms]
        return [_transform(one.header.frame_id, one.child_frame_id, one.transform) for one in m.transforms]

    def cloud(self, message: RawMessage, shape: tuple[int, int] | None = None) -> Cloud | None:
        """A cloud of any of the schemas `CLOUDS`; None where its points are not ordered as a picture.

        Args:
            message: the cloud.
            shape: (H, W) of the camera's picture, for schemas that do not say it.
        """
        m = self._message(message)
        if message.schema_name == "foxglove.PointCloud":
            names = {f.name: (f.offset, "<" + _BANDS.get(f.type, "u1")) for f in m.fields}
            points = _points(bytes(m.data), m.point_stride, 0, names)
            if shape is None or points is None or len(points) != shape[0] * shape[1]:
                return None
        else:
            order = ">" if m.is_bigendian else "<"
            names = {f.name: (f.offset, order + _ROS_BANDS.get(f.datatype, "u1")) for f in m.fields}
            points = _points(bytes(m.data), m.point_step, m.row_step, names, m.width, m.height)
            shape = (m.height, m.width)
            if m.height < 2 or points is None or len(points) != m.height * m.width:
                return None
        if not {"x", "y", "z"} <= set(points.dtype.names or ()):
            return None
        xyz = np.stack([points[axis] for axis in "xyz"], axis=-1).astype(np.float32)
        colour = _cloud_colour(points)
        return Cloud(
            _stamp(m),
            _frame(m),
            xyz.reshape(*shape, 3),
            None if colour is None else colour.reshape(*shape, 3),
        )

    def _message(self, message: RawMessage) -> Any:
        kind = _FOXGLOVE.get(message.schema_name)
        if kind is not None and message.encoding in ("protobuf", "json"):
            try:
                return foxglove_message(kind, message)
            except (DecodeError, ValueError):
                pass
        elif kind is None and (decoded := self._ros.decode(message)) is not None:
            return decoded
        raise FileError(
            self.path,
            f"{message.topic} holds a message that cannot be read as {message.schema_name} "
            f"(encoded in {message.encoding or '?'}, described in {message.schema_encoding or '?'})",
            "Expected Foxglove messages in protobuf or json, or ROS 2 messages in cdr described in ros2msg.",
        )


_UNCALIBRATED = (
    "Pass the camera's with --intrinsics FX,FY,CX,CY, or name another topic with --calibration-topic."
)


def _stamp(message: Any) -> int:
    if hasattr(message, "header"):
        return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)
    return int(message.timestamp.ToNanoseconds())


def _frame(message: Any) -> str:
    return str(message.header.frame_id if hasattr(message, "header") else message.frame_id).lstrip("/")


def _transform(parent: str, child: str, held: Any) -> Transform:
    t, q = held.translation, held.rotation
    rotation = [q.x, q.y, q.z, q.w] if any((q.x, q.y, q.z, q.w)) else [0, 0, 0, 1]
    return Transform(parent.lstrip("/"), child.lstrip("/"), normalised([t.x, t.y, t.z, *rotation]))


def _points(
    data: bytes,
    step: int,
    row_step: int,
    fields: dict[str, tuple[int, str]],
    width: int = 0,
    height: int = 1,
) -> NDArray[Any] | None:
    """The points as a structured array; None where the fields do not fit."""
    if step < 1 or any(offset + np.dtype(kind).itemsize > step for offset, kind in fields.values()):
        return None
    dtype = np.dtype(
        {
            "names": list(fields),
            "formats": [kind for _, kind in fields.values()],
            "offsets": [offset for offset, _ in fields.values()],
            "itemsize": step,
        }
    )
    if row_step > step * width and len(data) >= row_step * height:
        rows = np.frombuffer(data, np.uint8)[: row_step * height].reshape(height, row_step)
        data = rows[:, : step * width].tobytes()
    return np.frombuffer(data[: len(data) // step * step], dtype)


def _cloud_colour(points: NDArray[Any]) -> NDArray[np.uint8] | None:
    names = points.dtype.names or ()
    for packed in ("rgb", "rgba"):
        if packed in names:
            return unpacked_colour(points[packed])
    for bands in (("red", "green", "blue"), ("r", "g", "b")):
        if all(band in names for band in bands):
            found = np.stack([points[band] for band in bands], axis=-1)
            return np.asarray(255 * found if found.dtype.kind == "f" else found, np.uint8)
    return None
