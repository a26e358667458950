"""RGB-D recordings: opened, whatever their format; and written.

Written: MCAP with colour as JPEG and depth as 16-bit PNG of whole millimetres, both in
foxglove.CompressedImage, and one foxglove.CameraCalibration. Read: MCAP with Foxglove's or ROS 2's messages,
and folders in the layout of the TUM RGB-D benchmark.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from numpy.typing import NDArray

from imitate.formats.frames import MILLIMETRE
from imitate.formats.kind import METADATA, kind_of
from imitate.formats.mcap_writer import McapWriter, protobuf_channel
from imitate.formats.output import new_file, require_mcap
from imitate.formats.rgbd_mcap import open_mcap
from imitate.formats.tum import open_tum
from imitate.rgbd import Intrinsics, RgbdFrame, RgbdSource
from imitate.settings import Perception

CALIBRATION, COLOUR, DEPTH = "/camera/calibration", "/camera/colour", "/camera/depth"
QUALITY = 92
"""of the JPEG, with colour at full resolution: half resolution would blur hues over an edge by two pixels."""
_FRAME = "camera"


class Recording(RgbdSource, Protocol):
    """Frames from a file or a folder.

    Attributes:
        path: of the recording.
        notes: what the operator ought to know, in words; more may come while the frames are read.
        left_out: share of the frames that could be, were each picture in one, that are not; of those read.
    """

    path: Path
    notes: list[str]

    @property
    def left_out(self) -> float: ...

    def survey(self) -> None:
        """Goes through the stamps without the pictures; ``notes`` and ``left_out`` are known then."""


def open_recording(path: Path | str, settings: Perception | None = None) -> Recording:
    """What a recording holds, from its first pictures.

    Args:
        path: an MCAP file, or a folder with rgb.txt and depth.txt.
        settings: which topics, and whatever a recording does not say about its cameras itself.

    Raises:
        FileError: no such file, no recording, damaged, or without colour, depth or calibration.
    """
    path, settings = Path(path), settings or Perception()
    if path.is_dir():
        kind_of(path)
        return open_tum(path, settings)
    return open_mcap(path, settings)


def write_recording(
    path: Path | str, intrinsics: Intrinsics, frames: Iterable[RgbdFrame], force: bool = False
) -> int:
    """Writes frames as they come and returns how many.

    Raises:
        FileError: the file exists and ``force`` is not given, is not called .mcap, or cannot be written.
    """
    require_mcap(Path(path))
    channels = [
        protobuf_channel(CALIBRATION, CameraCalibration),
        protobuf_channel(COLOUR, CompressedImage),
        protobuf_channel(DEPTH, CompressedImage),
    ]
    metadata = {METADATA: {"kind": "recording", "depth_unit_m": str(MILLIMETRE)}}
    count = 0
    with (
        new_file(Path(path), force) as temporary,
        temporary.open("wb") as stream,
        McapWriter(stream, channels, metadata) as writer,
    ):
        for frame in frames:
            time = round(frame.t * 1e9)
            if not count:
                writer.write(CALIBRATION, calibration(intrinsics, time), time)
            writer.write(COLOUR, colour_picture(frame.colour, time), time)
            writer.write(DEPTH, _compressed(_png(frame.depth), "png", time), time)
            count += 1
    return count


def calibration(i: Intrinsics, time: int) -> CameraCalibration:
    """Foxglove's message of a pinhole camera without distortion, at ``time`` ns."""
    k = [i.fx, 0, i.cx, 0, i.fy, i.cy, 0, 0, 1]
    message = CameraCalibration(
        frame_id=_FRAME,
        width=i.width,
        height=i.height,
        K=k,
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[*k[:3], 0, *k[3:6], 0, *k[6:], 0],
        distortion_model="plumb_bob",
        D=[0, 0, 0, 0, 0],
    )
    message.timestamp.FromNanoseconds(time)
    return message


def colour_picture(colour: NDArray[np.uint8], time: int) -> CompressedImage:
    """Foxglove's message of a colour picture (H, W, 3), red green blue, at ``time`` ns: a JPEG."""
    return _compressed(_jpeg(colour), "jpeg", time)


def _compressed(data: bytes, form: str, time: int) -> CompressedImage:
    message = CompressedImage(frame_id=_FRAME, data=data, format=form)
    message.timestamp.FromNanoseconds(time)
    return message


def _jpeg(colour: NDArray[np.uint8]) -> bytes:
    full = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]
    _, data = cv2.imencode(".jpg", colour[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY, *full])
    return data.tobytes()


def _png(depth: NDArray[np.float32]) -> bytes:
    steps = np.clip(np.round(depth / MILLIMETRE), 0, 65535).astype(np.uint16)
    _, data = cv2.imencode(".png", steps, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    return data.tobytes()
