"""RGB-D recordings in MCAP: colour and depth pictures with the camera's calibration, as frames.

Written: colour as JPEG and depth as 16-bit PNG of whole millimetres, both in foxglove.CompressedImage, and
one foxglove.CameraCalibration. Read: also foxglove.RawImage (rgb8, bgr8; 16UC1, mono16 in millimetres;
32FC1 in metres). The two pictures of a frame are those whose times are nearest, within 40 ms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.kind import METADATA, listed
from imitate.formats.mcap_file import McapReader, McapWriter, RawMessage, contents, protobuf_channel
from imitate.formats.output import new_file, require_mcap
from imitate.rgbd import Intrinsics, RgbdFrame

CALIBRATION, COLOUR, DEPTH = "/camera/calibration", "/camera/colour", "/camera/depth"
UNIT = 0.001
"""m of one step of a 16-bit depth."""
QUALITY = 92
"""of the JPEG, with colour at full resolution: half resolution would blur hues over an edge by two pixels."""
APART = 40_000_000
"""ns, the most between the two pictures of one frame."""
_FRAME = "camera"
_REMEDY = (
    "A recording has colour and depth pictures (foxglove.CompressedImage or RawImage) and a "
    "foxglove.CameraCalibration; `imitate demonstrate stack -o FILE` makes one."
)


@dataclass(frozen=True)
class Recording:
    """A recording on disk, known to be whole.

    Attributes:
        count: how many depth pictures it has.
        colour, depth: topics.
    """

    path: Path
    intrinsics: Intrinsics
    count: int
    colour: str
    depth: str

    def frames(self) -> Iterator[RgbdFrame]:
        """Every frame in order, t in seconds from the first.

        Raises:
            FileError: a picture that cannot be decoded or has another size than the calibration says.
        """
        waiting: dict[str, tuple[int, NDArray[Any]]] = {}
        first: int | None = None
        for message in McapReader(self.path).messages({self.colour, self.depth}):
            time, picture = _stamped_picture(self.path, message)
            if picture.shape[:2] != (self.intrinsics.height, self.intrinsics.width):
                raise FileError(
                    self.path,
                    f"{message.topic} holds pictures of {picture.shape[1]}×{picture.shape[0]}, its "
                    f"calibration says {self.intrinsics.width}×{self.intrinsics.height}",
                    "Register both pictures to one camera and record that camera's calibration.",
                )
            waiting[message.topic] = (time, picture)
            if len(waiting) == 2 and abs(waiting[self.colour][0] - waiting[self.depth][0]) <= APART:
                first = time if first is None else first
                yield RgbdFrame((time - first) / 1e9, waiting[self.colour][1], waiting[self.depth][1])
                waiting.clear()


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
    metadata = {METADATA: {"kind": "recording", "depth_unit_m": str(UNIT)}}
    count = 0
    with (
        new_file(Path(path), force) as temporary,
        temporary.open("wb") as stream,
        McapWriter(stream, channels, metadata) as writer,
    ):
        for frame in frames:
            time = round(frame.t * 1e9)
            if not count:
                writer.write(CALIBRATION, _calibration(intrinsics, time), time)
            writer.write(COLOUR, _compressed(_jpeg(frame.colour), "jpeg", time), time)
            writer.write(DEPTH, _compressed(_png(frame.depth), "png", time), time)
            count += 1
    return count


def open_recording(path: Path | str) -> Recording:
    """What a recording holds, from its first messages.

    Raises:
        FileError: no such file, no MCAP, damaged, or without colour, depth or calibration.
    """
    path = Path(path)
    inside = contents(path)
    if inside.damage:
        raise FileError(path, f"is damaged: {inside.damage[0]}", "Record or copy it again.")
    if inside.metadata.get(METADATA, {}).get("kind") == "session":
        raise FileError(path, "is a session, not a recording", _REMEDY)
    intrinsics: Intrinsics | None = None
    pictures: dict[str, str] = {}
    topics = {topic for topic, (schema, count) in inside.topics.items() if count and schema in _PARSERS}
    for message in McapReader(path).messages(topics):
        if message.schema_name == CameraCalibration.DESCRIPTOR.full_name:
            intrinsics = intrinsics or _intrinsics(path, message)
        else:
            kind = "depth" if _stamped_picture(path, message)[1].ndim == 2 else "colour"
            pictures.setdefault(kind, message.topic)
        topics.discard(message.topic)
        if not topics:
            break
    for kind in ("colour", "depth"):
        if kind not in pictures:
            raise FileError(path, f"has no {kind} pictures; {listed(inside.topics)}", _REMEDY)
    if intrinsics is None:
        raise FileError(path, f"has no calibration of its camera; {listed(inside.topics)}", _REMEDY)
    depth = pictures["depth"]
    return Recording(path, intrinsics, inside.topics[depth][1], pictures["colour"], depth)


def _calibration(i: Intrinsics, time: int) -> CameraCalibration:
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


def _compressed(data: bytes, form: str, time: int) -> CompressedImage:
    message = CompressedImage(frame_id=_FRAME, data=data, format=form)
    message.timestamp.FromNanoseconds(time)
    return message


def _jpeg(colour: NDArray[np.uint8]) -> bytes:
    full = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]
    _, data = cv2.imencode(".jpg", colour[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY, *full])
    return data.tobytes()


def _png(depth: NDArray[np.float32]) -> bytes:
    steps = np.clip(np.round(depth / UNIT), 0, 65535).astype(np.uint16)
    _, data = cv2.imencode(".png", steps, [cv2.IMWRITE_PNG_COMPRESSION, 6])
    return data.tobytes()


def _intrinsics(path: Path, message: RawMessage) -> Intrinsics:
    c: CameraCalibration = _parsed(path, message)
    if len(c.K) != 9 or c.K[0] <= 0 or c.K[4] <= 0:
        raise FileError(path, f"{message.topic} calibrates no camera: K is {list(c.K)}", _REMEDY)
    return Intrinsics(c.width, c.height, c.K[0], c.K[4], c.K[2], c.K[5])


def _stamped_picture(path: Path, message: RawMessage) -> tuple[int, NDArray[Any]]:
    """(nanoseconds, (H, W, 3) uint8 red green blue or (H, W) float32 metres)."""
    parsed = _parsed(path, message)
    stamp = parsed.timestamp.ToNanoseconds() or message.time
    picture = _decoded(parsed) if isinstance(parsed, CompressedImage) else _unpacked(parsed)
    if picture is None:
        form = parsed.format if isinstance(parsed, CompressedImage) else parsed.encoding
        raise FileError(
            path, f"{message.topic} holds a {form or 'nameless'} picture that cannot be decoded", _REMEDY
        )
    return stamp, picture


def _decoded(message: CompressedImage) -> NDArray[Any] | None:
    data = np.frombuffer(message.data, np.uint8)
    picture = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if len(data) else None
    if picture is None:
        return None
    if picture.ndim == 2 and picture.dtype == np.uint16:
        return (picture * np.float32(UNIT)).astype(np.float32)
    if picture.ndim == 3 and picture.dtype == np.uint8:
        return np.asarray(picture[..., 2::-1])
    return None


def _unpacked(message: RawImage) -> NDArray[Any] | None:
    form = _RAW.get(message.encoding)
    if form is None or len(message.data) < message.step * message.height:
        return None
    kind, channels, finish = form
    rows = np.frombuffer(message.data, np.uint8)[: message.step * message.height]
    width = message.width * channels * kind.itemsize
    if message.step < width:
        return None
    packed = np.ascontiguousarray(rows.reshape(message.height, message.step)[:, :width])
    return finish(packed.view(kind).reshape(message.height, message.width, channels))


def _metres(steps: NDArray[Any]) -> NDArray[Any]:
    return (steps[..., 0] * np.float32(UNIT)).astype(np.float32)


_RAW: dict[str, tuple[np.dtype[Any], int, Callable[[NDArray[Any]], NDArray[Any]]]] = {
    "rgb8": (np.dtype(np.uint8), 3, lambda picture: picture),
    "bgr8": (np.dtype(np.uint8), 3, lambda picture: picture[..., ::-1]),
    "16UC1": (np.dtype("<u2"), 1, _metres),
    "mono16": (np.dtype("<u2"), 1, _metres),
    "32FC1": (np.dtype("<f4"), 1, lambda picture: np.nan_to_num(picture[..., 0], posinf=0, neginf=0)),
}
_PARSERS: dict[str, Any] = {
    kind.DESCRIPTOR.full_name: kind for kind in (CameraCalibration, CompressedImage, RawImage)
}


def _parsed(path: Path, message: RawMessage) -> Any:
    try:
        return _PARSERS[message.schema_name].FromString(message.data)
    except DecodeError:
        raise FileError(
            path, f"{message.topic} holds a message that is no {message.schema_name}", "Record it again."
        ) from None
