"""The pictures of a recording, small, to be looked at by time."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.settings import Perception

Image = NDArray[np.uint8]

WIDTH = 192
"""pixels at most: no terminal shows more of it beside the scene."""
MOST = 3000
"""pictures that are kept at most, about 10 MB: of longer recordings every second or third one."""


@dataclass(frozen=True)
class Shot:
    """One picture: seconds since the first one, and the JPEG."""

    t: float
    jpeg: bytes


@dataclass(frozen=True)
class Wanted:
    """The pictures of which recording, or of a session that keeps them."""

    source: Path
    settings: Perception


@dataclass
class Album:
    """Pictures as they are read, in order."""

    shots: list[Shot] = field(default_factory=list)
    asked: bool = False
    stopping: bool = False

    def take(self, said: Shot | object) -> None:
        """A picture, or None at the end."""
        if isinstance(said, Shot):
            self.shots.append(said)

    def nearest(self, t: float) -> Shot | None:
        """The picture nearest in time to ``t`` seconds; None while there is none."""
        k = bisect_left(self.shots, t, key=lambda shot: shot.t)
        return min(self.shots[max(k - 1, 0) : k + 1], key=lambda shot: abs(shot.t - t), default=None)


def opened(shot: Shot) -> Image:
    """(H, W, 3) red green blue."""
    decoded = cv2.imdecode(np.frombuffer(shot.jpeg, np.uint8), cv2.IMREAD_COLOR)
    return np.asarray(decoded, np.uint8)[..., ::-1]


def shot_of(t: float, colour: Image) -> Shot:
    """A picture (H, W, 3) at ``t`` seconds, made small."""
    height, width = colour.shape[:2]
    if width > WIDTH:
        size = (WIDTH, max(1, round(height * WIDTH / width)))
        colour = np.asarray(cv2.resize(colour, size, interpolation=cv2.INTER_AREA), np.uint8)
    return Shot(t, cv2.imencode(".jpg", np.ascontiguousarray(colour[..., ::-1]))[1].tobytes())


def read_pictures(wanted: Wanted, emit: Callable[[Any], None], should_stop: Callable[[], bool]) -> None:
    """Emits a recording's pictures as `Shot`s, in order; none of a session that keeps none."""
    from imitate.formats.kind import kind_of

    session = kind_of(wanted.source) == "session"
    first: float | None = None
    for t, colour in _kept(wanted.source) if session else _filmed(wanted):
        if should_stop():
            return
        first = t if first is None else first
        emit(shot_of(t - first, colour))


def _filmed(wanted: Wanted) -> Iterator[tuple[float, Image]]:
    from imitate.formats.recordings import open_recording

    recording = open_recording(wanted.source, wanted.settings)
    every = max(1, -(-recording.count // MOST))
    for k, frame in enumerate(recording.frames()):
        if k % every == 0:
            yield frame.t, frame.colour


def _kept(session: Path) -> Iterator[tuple[float, Image]]:
    from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

    from imitate.formats.recordings import COLOUR
    from imitate.formats.session_pictures import kept_pictures

    for topic, data, time in kept_pictures(session) or ():
        if topic == COLOUR:
            yield time / 1e9, opened(Shot(0.0, CompressedImage.FromString(data).data))
