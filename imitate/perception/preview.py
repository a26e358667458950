"""What was observed, drawn over the pictures: the blocks' edges, the fingers' cylinders, names, tracks."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import HAND
from imitate.errors import FileError
from imitate.formats.output import new_file
from imitate.geometry import Array, compose, inverse, rotate
from imitate.perception.first_view import FirstView
from imitate.perception.hand import SIDES, finger_poses
from imitate.perception.observe import Observation
from imitate.rgbd import Intrinsics, PointCloud, RgbdFrame
from imitate.settings import Perception

Image = NDArray[np.uint8]
Ink = tuple[int, int, int]
INK: tuple[Ink, ...] = (
    (255, 255, 255),
    (255, 64, 220),
    (64, 220, 255),
    (255, 160, 32),
    (140, 255, 100),
    (170, 140, 255),
)
"""red green blue of the hand, then of one object after the other, over again where they are more."""
LOST = (255, 48, 48)
HEIGHT = 480
"""pixels; smaller pictures are enlarged, so that names can be read."""
_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]
CORNERS = np.array([[(k >> axis & 1) - 0.5 for axis in range(3)] for k in range(8)])
"""(8, 3) of a box of side 1 around its middle."""


class Sketch:
    """A picture and the camera that took it; what is drawn is given in the camera's frame.

    Attributes:
        image: the picture with all that was drawn, a whole number of times as large.
    """

    def __init__(self, picture: Image, intrinsics: Intrinsics) -> None:
        self._scale = max(1, round(HEIGHT / intrinsics.height))
        tall, wide = (self._scale * side for side in picture.shape[:2])
        self.image: Image = np.array(
            cv2.resize(picture, (wide, tall), interpolation=cv2.INTER_NEAREST), np.uint8
        )
        self._camera = intrinsics
        self._width = max(1, round(tall / HEIGHT))
        self._letters = tall / 1000

    def line(self, points: Array, ink: Ink) -> None:
        """Points (N, 3), metres, joined where both ends are in front of the camera; NaN parts them."""
        pixels = self._pixels(points)
        for a, b in pairwise(pixels):
            if np.isfinite([a, b]).all() and np.abs([a, b]).max() < 1e5:
                start, end = ([round(float(v)) for v in pixel] for pixel in (a, b))
                cv2.line(self.image, start, end, ink, self._width, cv2.LINE_AA)

    def box(self, pose: Array, size: Array, ink: Ink) -> None:
        """The twelve edges of a box at a pose (7,) of its middle, size (3,) metres."""
        corners = pose[:3] + rotate(pose[3:], CORNERS * size)
        for a, b in _EDGES:
            self.line(corners[[a, b]], ink)

    def cylinder(self, pose: Array, radius: float, length: float, ink: Ink) -> None:
        """Both ends and four sides of a cylinder around the z of the pose (7,) of its middle."""
        ends = [pose[:3] + rotate(pose[3:], rim) for rim in rims(radius, length)]
        for end in ends:
            self.line(end, ink)
        for k in range(0, len(ends[0]) - 1, 6):
            self.line(np.stack([ends[0][k], ends[1][k]]), ink)

    def name(self, text: str, point: Array, ink: Ink) -> None:
        """Words beside a point (3,)."""
        (pixel,) = self._pixels(point[None])
        if np.isfinite(pixel).all() and np.abs(pixel).max() < 1e5:
            self._words(text, round(float(pixel[0])) + 6, round(float(pixel[1])) - 6, ink)

    def note(self, text: str, row: int, ink: Ink) -> None:
        """Words in the corner, on a row of their own."""
        self._words(text, 8, round((row + 1) * 45 * self._letters), ink)

    def _words(self, text: str, x: int, y: int, ink: Ink) -> None:
        font, shade = cv2.FONT_HERSHEY_SIMPLEX, (0, 0, 0)
        for right, down, colour in ((1, 1, shade), (-1, -1, shade), (0, 0, ink)):
            at = (x + right, y + down)
            cv2.putText(self.image, text, at, font, self._letters, colour, self._width, cv2.LINE_AA)

    def _pixels(self, points: Array) -> Array:
        return (self._camera.project(points) + 0.5) * self._scale - 0.5


def draw_frame(
    frame: RgbdFrame, intrinsics: Intrinsics, seen: Observation, k: int, settings: Perception
) -> Image:
    """Frame ``k`` with hand and objects where they were seen, and in red the names of those that were not."""
    return _sketched(frame, intrinsics, seen, k, settings).image


def draw_tracks(frame: RgbdFrame, intrinsics: Intrinsics, seen: Observation, settings: Perception) -> Image:
    """The first frame, and over it the way of each body through the whole recording."""
    sketch = _sketched(frame, intrinsics, seen, 0, settings)
    for n, body in enumerate((HAND, *seen.demonstration.object_names)):
        way = compose(seen.camera_from_table, seen.demonstration.pose_of(body))[:, :3]
        sketch.line(way, ink_of(n))
    return sketch.image


def draw_first_view(picture: Image, intrinsics: Intrinsics, first: FirstView) -> Image:
    """A picture (H, W, 3) of a single view, its objects tinted and their blocks drawn."""
    labels = first.labels.reshape(picture.shape[:2])
    tinted = picture.astype(float)
    for n in range(len(first.objects)):
        tinted[labels == n + 1] = 0.5 * tinted[labels == n + 1] + 0.5 * np.array(ink_of(n + 1))
    sketch = Sketch(tinted.astype(np.uint8), intrinsics)
    for n, thing in enumerate(first.objects):
        pose = compose(inverse(first.table.table_from_camera), thing.block.pose)
        sketch.box(pose, thing.block.size, ink_of(n + 1))
        sketch.name(f"{thing.name}{' (uncertain)' if thing.uncertain else ''}", pose[:3], ink_of(n + 1))
    return sketch.image


def picture_of_cloud(cloud: PointCloud) -> Image:
    """(H, W, 3) the colours of an organised cloud, or greys that are lighter where it is nearer."""
    shape = cloud.shape or (1, len(cloud.points))
    if cloud.colour is not None:
        return cloud.colour.reshape(*shape, 3)
    z = cloud.points[:, 2]
    low, high = np.nanpercentile(z, [2, 98])
    grey = np.nan_to_num(255 * np.clip((high - z) / max(high - low, 1e-6), 0.1, 1))
    return np.repeat(grey.astype(np.uint8), 3).reshape(*shape, 3)


def write_picture(path: Path, image: Image, force: bool = False) -> None:
    """Writes a picture (H, W, 3) red green blue, as its suffix says.

    Raises:
        FileError: it exists and ``force`` is not given, or cannot be written.
    """
    _, data = cv2.imencode(path.suffix, image[..., ::-1])
    with new_file(path, force) as temporary:
        temporary.write_bytes(data.tobytes())


def write_film(path: Path, images: Iterable[Image], rate: float, force: bool = False) -> None:
    """Writes pictures (H, W, 3) as MP4, at ``rate`` frames a second.

    Raises:
        FileError: it exists and ``force`` is not given, or cannot be written.
    """
    with new_file(path, force) as temporary:
        # OpenCV takes the container from the suffix
        film = temporary.with_suffix(".mp4")
        writer = None
        try:
            for image in images:
                if writer is None:
                    size = (image.shape[1], image.shape[0])
                    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"mp4v"), rate, size)
                    if not writer.isOpened():
                        raise FileError(path, "cannot be written as MP4 by this OpenCV", "Give a .png.")
                writer.write(np.ascontiguousarray(image[..., ::-1]))
        finally:
            if writer is not None:
                writer.release()
            if film.exists():
                film.replace(temporary)


def _sketched(
    frame: RgbdFrame, intrinsics: Intrinsics, seen: Observation, k: int, settings: Perception
) -> Sketch:
    sketch = Sketch(frame.colour, intrinsics)
    unseen = []
    for n, body in enumerate((HAND, *seen.demonstration.object_names)):
        pose = compose(seen.camera_from_table, seen.demonstration.pose_of(body)[k])
        if np.isnan(pose[0]):
            unseen.append(body)
        else:
            _draw_body(sketch, body, pose, seen, k, ink_of(n), settings)
    for row, body in enumerate(unseen):
        sketch.note(f"{body}: lost", row, LOST)
    return sketch


def _draw_body(
    sketch: Sketch,
    body: str,
    pose: Array,
    seen: Observation,
    k: int,
    ink: Ink,
    settings: Perception,
) -> None:
    sketch.name(body, pose[:3], ink)
    if body != HAND:
        sketch.box(pose, seen.demonstration.size_of(body), ink)
        return
    assert seen.demonstration.opening is not None  # what is observed has it
    for side in SIDES:
        (finger,) = finger_poses(pose[None], seen.demonstration.opening[k : k + 1], settings, side)
        sketch.cylinder(finger, settings.finger_radius, settings.finger_length, ink)


def rims(radius: float, length: float) -> tuple[Array, Array]:
    """(25, 3) each, points around both ends of a cylinder along z about its middle, the lower end first."""
    turn = np.linspace(0, 2 * np.pi, 25)
    below, above = (
        np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(25, z)], axis=1)
        for z in (-length / 2, length / 2)
    )
    return below, above


def ink_of(n: int) -> Ink:
    """What body ``n`` is drawn in, the hand being 0."""
    return INK[0] if n == 0 else INK[1 + (n - 1) % (len(INK) - 1)]
