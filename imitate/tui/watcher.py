"""Looks over the tracker's shoulder, in the child: keeps small pictures, and tells now and then."""

from __future__ import annotations

import time
from collections.abc import Callable

import cv2
import numpy as np

from imitate.demonstration import HAND
from imitate.geometry import IDENTITY, inverse
from imitate.perception.hand import SIDES, finger_poses
from imitate.perception.observe import Moment
from imitate.perception.preview import CORNERS, ink_of, rims
from imitate.perception.tracker import Sight
from imitate.settings import Perception
from imitate.tui.sighting import Cast, Image, Sighting

WIDEST, HIGHEST = 160, 120
"""pixels of a picture that is kept, at most."""
MOST = 2000
"""pictures that are kept of a recording, evenly: about 8 MB."""
QUALITY = 85
"""of a JPEG."""
EVERY = 0.25
"""s between two tellings."""


class Watcher:
    """Called with each `Moment`; ``tell`` hears of the frames since it last did, as a `Sighting`."""

    def __init__(
        self,
        settings: Perception,
        tell: Callable[[Sighting], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._settings, self._tell, self._clock = settings, tell, clock
        self._cast: Cast | None = None
        self._rows: list[tuple[float, tuple[Sight, ...], float]] = []
        self._pictures: list[bytes] = []
        self._told, self._last = 0, -np.inf

    def __call__(self, moment: Moment) -> None:
        """Take a frame in."""
        self._cast = self._cast or cast_of(moment, self._settings)
        number = self._told + len(self._rows)
        kept = number % -(-moment.count // MOST) == 0
        self._pictures.append(small(moment.frame.colour) if kept else b"")
        self._rows.append((moment.frame.t, moment.sights, moment.opening))
        if self._clock() - self._last >= EVERY:
            self._say(self._cast, moment.count)

    def end(self) -> None:
        """Tell what was not told yet: there are no more frames, whatever had been known of their number."""
        if self._cast is not None:
            self._say(self._cast, self._told + len(self._rows))

    def _say(self, cast: Cast, count: int) -> None:
        times, sights, openings = zip(*self._rows, strict=True) if self._rows else ((), (), ())
        bodies, missing = len(cast.names), np.full(7, np.nan)
        poses = [[missing if one.pose is None else one.pose for one in row] for row in sights]
        confidence = [[one.confidence for one in row] for row in sights]
        said = Sighting(
            cast,
            begin=self._told,
            count=count,
            t=np.array(times),
            poses=np.array(poses).reshape(-1, bodies, 7),
            openings=np.array(openings),
            confidence=np.array(confidence).reshape(-1, bodies),
            pictures=tuple(self._pictures),
        )
        self._told += len(said)
        self._rows, self._pictures, self._last = [], [], self._clock()
        self._tell(said)


def small(colour: Image) -> bytes:
    """The JPEG of a picture (H, W, 3), red green blue, scaled down."""
    height, width = colour.shape[:2]
    scale = min(WIDEST / width, HIGHEST / height, 1.0)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    shown = cv2.resize(colour, size, interpolation=cv2.INTER_AREA) if scale < 1 else colour
    _, data = cv2.imencode(".jpg", shown[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return data.tobytes()


def cast_of(moment: Moment, settings: Perception) -> Cast:
    """Who is followed, from any frame."""
    things = moment.first.objects
    around = np.concatenate(rims(settings.finger_radius, settings.finger_length))
    closed = [finger_poses(IDENTITY[None], np.zeros(1), settings, side)[0, :3] for side in SIDES]
    return Cast(
        names=(HAND, *(thing.name for thing in things)),
        inks=tuple(ink_of(n) for n in range(1 + len(things))),
        blocks=np.array([CORNERS * thing.block.size for thing in things]),
        fingers=np.array([middle + around for middle in closed]),
        camera=moment.intrinsics,
        camera_from_table=inverse(moment.first.table.table_from_camera),
    )
