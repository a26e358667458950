"""A recording in MCAP of coloured clouds whose points are a picture's pixels, as frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.camera_messages import Calibration, CameraReader
from imitate.formats.clock import Both, astray_note, whose_clock
from imitate.formats.distances import check_distances
from imitate.formats.frames import damaged
from imitate.formats.kind import CLOUDS
from imitate.formats.mcap_contents import Contents
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.organised import fitted_intrinsics
from imitate.formats.picture_times import peeked, steady
from imitate.formats.sensor_frame import OPTICAL, SensorFrame, turned_frame
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception

_Read = tuple[Both, NDArray[np.uint8], NDArray[np.float32]]
"""when a cloud was taken, its colour and its depth."""
_REMEDY = "Record colour and depth pictures; or write one cloud as a PCD or PLY file, and observe that."


@dataclass
class CloudRecording:
    """Clouds of one topic, opened.

    Attributes:
        unit: metres of 1.0 in a point.
        salvage: whether damage is put up with.
        notes: what the operator ought to know, in words; more may come while the frames are read.
        left_out: share of the clouds that are no frames, once they are read.
        frame: in which the clouds are given.
    """

    path: Path
    topic: str
    intrinsics: Intrinsics
    count: int
    unit: float
    salvage: bool
    notes: list[str] = field(default_factory=list)
    left_out: float = 0.0
    frame: SensorFrame = OPTICAL

    def frames(self) -> Iterator[RgbdFrame]:
        """Every cloud as a frame, read as it is asked for; t in seconds from the first.

        Raises:
            FileError: a cloud without colour or not ordered as the first is, or damage that shows only now.
        """
        reader, off, shown = McapReader(self.path), list[Both](), 0
        first, clouds = peeked(self._read(reader))
        clock = whose_clock({self.topic: [times for times, _, _ in first]}, self.notes)
        kept = steady(
            self.path, self.topic, clouds, lambda one: one[0][clock], lambda one: off.append(one[0])
        )
        begin, last = 0, None
        for times, colour, depth in kept:
            if last is not None and times[clock] <= last:
                off.append(times)
                continue
            last = times[clock]
            begin, shown = begin if shown else last, shown + 1
            yield RgbdFrame((last - begin) / 1e9, colour, depth)
        if reader.damage and not self.salvage:
            raise damaged(self.path, reader.damage[0])
        self.left_out = len(off) / max(1, len(off) + shown)
        if (
            off
            and (note := astray_note(f"clouds of {self.topic}", len(off), len(off) + shown)) not in self.notes
        ):
            self.notes.append(note)

    def survey(self) -> None:
        """Goes through the clouds; ``notes`` and ``left_out`` are known then. Raises as `frames`."""
        for _ in self.frames():
            pass

    def _read(self, reader: McapReader) -> Iterator[_Read]:
        camera, shape = CameraReader(self.path), (self.intrinsics.height, self.intrinsics.width)
        for message in reader.messages({self.topic}):
            cloud = camera.cloud(message, shape)
            if cloud is None or cloud.points.shape[:2] != shape or cloud.colour is None:
                raise _unordered(self.path, message)
            depth = self.frame.seen(cloud.points)[..., 2] * self.unit
            depth = np.nan_to_num(depth, nan=0, posinf=0, neginf=0)
            yield (cloud.time, message.time), cloud.colour, np.maximum(depth, 0)


def open_clouds(
    path: Path, inside: Contents, calibrations: dict[str, Calibration], settings: Perception
) -> CloudRecording | None:
    """The clouds of a recording as frames; None where it has no clouds.

    Raises:
        FileError: its clouds are not ordered as pictures, have no colour, or can be no camera's.
    """
    topics = {t for t, (schema, count) in inside.topics.items() if count and schema in CLOUDS}
    if settings.depth_topic:
        topics &= {settings.depth_topic}
    camera = CameraReader(path)
    lenses = [one.lens.intrinsics for one in calibrations.values()]
    shapes = [None, *((lens.height, lens.width) for lens in lenses)]
    refused: FileError | None = None
    for message in McapReader(path).messages(topics) if topics else ():
        clouds = [camera.cloud(message, shape) for shape in shapes]
        cloud = next((one for one in clouds if one is not None), None)
        if cloud is None or cloud.colour is None:
            refused = refused or _unordered(path, message)
            continue
        unit = settings.depth_unit or 1.0
        points = cloud.points * unit
        frame = turned_frame(points)
        intrinsics = fitted_intrinsics(frame.seen(points)) if frame else None
        if frame is None or intrinsics is None:
            problem = f"{message.topic} holds clouds that no camera at their origin sees, however it looks"
            raise FileError(path, problem, f"Record them in the camera's own frame. {_REMEDY}")
        if not settings.depth_unit:
            z = frame.seen(points)[..., 2]
            check_distances(path, message.topic, z[z > 0], unit)
        count = inside.topics[message.topic][1]
        others = sorted(topics - {message.topic})
        notes = (
            [f"clouds are taken from {message.topic}, not from {', '.join(others)} (--depth-topic)"]
            if others
            else []
        )
        if frame.words:
            notes.append(f"{message.topic}: its frame is taken as that {frame.words}")
        return CloudRecording(
            path, message.topic, intrinsics, count, unit, settings.salvage, notes, frame=frame
        )
    if refused is not None:
        raise refused
    return None


def _unordered(path: Path, message: RawMessage) -> FileError:
    return FileError(
        path,
        f"{message.topic} holds clouds without colour, or whose points are not in a picture's order",
        _REMEDY,
    )
