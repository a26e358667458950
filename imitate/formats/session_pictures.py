"""The pictures of a recording within the session that was learned from it.

Colour as foxglove.CompressedImage and its calibration, as in a recording of ours; depth as ROS 2's Image of
whole millimetres, which Rerun draws as a depth image. They lie among the demonstration's poses, by time.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from numpy.typing import NDArray

from imitate.formats.frames import MILLIMETRE
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader
from imitate.formats.mcap_writer import Channel, protobuf_channel
from imitate.formats.recordings import CALIBRATION, COLOUR, DEPTH, calibration, colour_picture
from imitate.formats.session_messages import Stamped
from imitate.rgbd import RgbdSource

TOPICS = (CALIBRATION, COLOUR, DEPTH)

_IMAGE = """\
std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""

DEPTH_CHANNEL = Channel(DEPTH, "cdr", "sensor_msgs/msg/Image", "ros2msg", _IMAGE.encode())


def picture_channels() -> list[Channel]:
    """Their topics."""
    return [
        protobuf_channel(CALIBRATION, CameraCalibration),
        protobuf_channel(COLOUR, CompressedImage),
        DEPTH_CHANNEL,
    ]


def pictures_of(recording: RgbdSource) -> Iterator[Stamped]:
    """The messages of a recording's frames, time from its first frame."""
    first = None
    for frame in recording.frames():
        time = round(frame.t * 1e9)
        if first is None:
            first = time
            yield CALIBRATION, calibration(recording.intrinsics, 0).SerializeToString(deterministic=True), 0
        time -= first
        yield COLOUR, colour_picture(frame.colour, time).SerializeToString(deterministic=True), time
        yield DEPTH, depth_image(frame.depth, time), time


def kept_pictures(session: Path) -> Iterator[Stamped] | None:
    """The messages that a session has of pictures, as they are; None where it has none."""
    if not set(TOPICS) & contents(session).topics.keys():
        return None
    return ((m.topic, m.data, m.time) for m in McapReader(session).messages(TOPICS))


def depth_image(depth: NDArray[np.float32], time: int, frame: str = "camera") -> bytes:
    """A sensor_msgs/msg/Image of encoding 16UC1 in little-endian CDR, for depth (H, W) in metres.

    Written by hand, because it is one message of fixed form. Alignment counts from the end of the header.
    """
    height, width = depth.shape
    steps = np.clip(np.round(depth / MILLIMETRE), 0, 65535).astype("<u2").tobytes()
    body = struct.pack("<iI", *divmod(time, 1_000_000_000)) + _string(frame)
    body += b"\0" * (-len(body) % 4) + struct.pack("<II", height, width) + _string("16UC1") + b"\0"
    body += b"\0" * (-len(body) % 4) + struct.pack("<II", 2 * width, len(steps))
    return b"\0\1\0\0" + body + steps


def _string(text: str) -> bytes:
    data = text.encode() + b"\0"
    return struct.pack("<I", len(data)) + data
