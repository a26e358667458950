"""Frames of a recording as they were tracked: what Observe shows, while it is tracked and afterwards."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, read_only, rotate
from imitate.rgbd import Intrinsics

Image = NDArray[np.uint8]
Ink = tuple[int, int, int]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Cast:
    """Who is followed, and by which camera; the same in every frame.

    Attributes:
        names: the hand's, then those of K objects.
        inks: red green blue in which each is drawn.
        blocks: (K, 8, 3) metres, the corners of each object in its own frame.
        fingers: (2, P, 3) metres, around the left and right finger of the closed hand, in its frame.
        camera: of the pictures.
        camera_from_table: (7,).
    """

    names: tuple[str, ...]
    inks: tuple[Ink, ...]
    blocks: Array
    fingers: Array
    camera: Intrinsics
    camera_from_table: Array

    def __post_init__(self) -> None:
        for name in ("blocks", "fingers", "camera_from_table"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


@dataclass(frozen=True, eq=False)
class Sighting:
    """N frames in a row.

    Attributes:
        begin: number of the first of them.
        count: frames of the whole recording, as far as is known.
        t: (N,) seconds since the recording's first frame.
        poses: (N, 1+K, 7) of hand and objects in the table's frame; seven NaN where one was not seen.
        openings: (N,) metres between the fingers; NaN where they were not seen.
        confidence: (N, 1+K) 0…1, as the tracker says it; 0 where one was not seen.
        pictures: of each frame a small JPEG; empty of those that none is kept of.
    """

    cast: Cast
    begin: int
    count: int
    t: Array
    poses: Array
    openings: Array
    confidence: Array
    pictures: tuple[bytes, ...]

    def __post_init__(self) -> None:
        for name in ("t", "poses", "openings", "confidence"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.t)

    def then(self, later: Sighting) -> Sighting:
        """These frames and the later ones."""
        return Sighting(
            self.cast,
            self.begin,
            later.count,
            t=np.concatenate([self.t, later.t]),
            poses=np.concatenate([self.poses, later.poses]),
            openings=np.concatenate([self.openings, later.openings]),
            confidence=np.concatenate([self.confidence, later.confidence]),
            pictures=self.pictures + later.pictures,
        )

    @property
    def share(self) -> float:
        """0…1 of the recording that was tracked."""
        return (self.begin + len(self)) / max(self.count, 1)

    @property
    def lost(self) -> Bools:
        """(N, 1+K) whether a body was not seen."""
        return np.isnan(self.poses[..., 0])

    @property
    def lost_seconds(self) -> Array:
        """(1+K,) each frame in which a body was not seen counts until the next one."""
        steps = np.diff(self.t)
        usual = float(np.median(steps)) if len(steps) else 0.0
        return np.asarray(np.append(steps, usual)[: len(self)] @ self.lost)

    def pictured(self, k: int) -> int | None:
        """The last frame up to ``k`` that has a picture."""
        return next((i for i in range(min(k, len(self) - 1), -1, -1) if self.pictures[i]), None)

    def at(self, seconds: float) -> int:
        """The frame nearest to a time."""
        return int(np.argmin(np.abs(self.t - seconds)))

    def picture(self, k: int) -> Image:
        """(H, W, 3) red green blue, of a frame that has one."""
        data = np.frombuffer(self.pictures[k], np.uint8)
        return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR_RGB), np.uint8)

    def outlines(self, k: int, body: int) -> list[Array]:
        """Closed lines (P, 2) around a body in frame ``k``, as shares of the picture's width and height.

        None where it was not seen; of the hand one around each finger.
        """
        pose = self.poses[k, body]
        if np.isnan(pose[0]):
            return []
        solids = [self.cast.blocks[body - 1]] if body else list(self._fingers(k))
        rings = [_ring(self._shares(pose[:3] + rotate(pose[3:], solid))) for solid in solids]
        return [ring for ring in rings if len(ring)]

    def way(self, k: int, body: int, seconds: float) -> list[Array]:
        """Lines (P, 2) along which a body's middle came to frame ``k``; parted where it was not seen."""
        first = int(np.searchsorted(self.t, self.t[k] - seconds))
        seen = self._shares(self.poses[first : k + 1, body, :3])
        gaps = np.flatnonzero(np.isnan(seen[:, 0]))
        parts = [part[~np.isnan(part[:, 0])] for part in np.split(seen, gaps)]
        return [part for part in parts if len(part) > 1]

    def _fingers(self, k: int) -> Array:
        apart = np.zeros((2, 1, 3))
        apart[:, 0, 1] = np.array([-1, 1]) * self.openings[k] / 2
        return np.asarray(self.cast.fingers + apart)

    def _shares(self, points: Array) -> Array:
        # (N, 2) where points (N, 3) in the table's frame are in the picture; 0…1 inside it
        camera, pose = self.cast.camera, self.cast.camera_from_table
        pixels = camera.project(pose[:3] + rotate(pose[3:], points))
        return np.asarray((pixels + 0.5) / [camera.width, camera.height])


def _ring(points: Array) -> Array:
    if np.isnan(points).any():
        return np.zeros((0, 2))
    hull = cv2.convexHull(points.astype(np.float32))[:, 0].astype(float)
    return np.vstack([hull, hull[:1]])
