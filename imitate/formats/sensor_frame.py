"""Where in a cloud's frame its sensor is and which way it looks: programs differ, and few say it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from imitate.formats.organised import fitted_intrinsics
from imitate.geometry import IDENTITY, Array, compose, conjugate, rotate

Shape = tuple[int, int] | None

AXES: dict[str, tuple[str, Array]] = {
    "optical": ("x right, y down, z forward", np.array([0.0, 0, 0, 0, 0, 0, 1])),
    "graphics": ("x right, y up, z towards the sensor", np.array([0.0, 0, 0, 1, 0, 0, 0])),
    "body": ("x forward, y left, z up", np.array([0.0, 0, 0, -0.5, 0.5, -0.5, 0.5])),
}
"""of a sensor's own frame: in words, and the pose (7,) in it of the optical frame, which is used here."""
SENSORS = f"{', '.join(AXES)}, viewpoint, or the camera's pose X,Y,Z,QX,QY,QZ,QW in the cloud's frame"
"""what a frame may be named."""
AHEAD = 0.99
"""share of the points that lie before a sensor, at least: a few are stray."""
CLEARLY = 0.05
"""by which points must lie nearer to another sensor's axis, as a cosine, before that one is taken."""


@dataclass(frozen=True)
class SensorFrame:
    """A sensor's optical frame (x right, y down, z forward) in a cloud's.

    Attributes:
        pose: (7,) in the cloud's frame, metres.
        words: how the cloud's frame lies, for the operator; empty where it is the optical one.
    """

    pose: Array
    words: str

    def seen(self, points: NDArray[np.floating]) -> Array:
        """Points (..., 3) of the cloud's frame in the optical one."""
        if not self.words:
            return np.asarray(points, float)
        return rotate(conjugate(self.pose[3:]), points - self.pose[:3])


OPTICAL = SensorFrame(IDENTITY, "")


def named_frame(name: str, viewpoint: Array | None, points: Array, shape: Shape) -> SensorFrame | None:
    """The frame that is called so: one of `AXES`, "viewpoint", seven numbers, or "": found from the points.

    Args:
        viewpoint: (7,) the sensor's pose in a world in which the points may be given; None: not known.
        points: (N, 3) of the cloud; NaN where nothing was read.
        shape: (H, W) where they are a picture's pixels, row by row.

    Returns:
        None where no frame that is looked at has the points before the sensor.
    """
    own = [_frame(axes, None) for axes in AXES]
    of_world = [] if viewpoint is None else [_frame(axes, viewpoint) for axes in AXES]
    if name in AXES:
        return own[list(AXES).index(name)]
    if name == "viewpoint":
        return _nearest(of_world, points, shape)
    if name:
        return SensorFrame(
            np.array([float(word) for word in name.split(",")]), "in which you place the camera"
        )
    return _nearest([*own, *of_world], points, shape)


def turned_frame(points: NDArray[np.floating]) -> SensorFrame | None:
    """The axes along which a camera at the origin sees each of the points (H, W, 3) in its own pixel.

    All twenty-four ways are looked at. None where there is no such camera.
    """
    for turn in [Rotation.identity(), *Rotation.create_group("O")]:
        if fitted_intrinsics(turn.inv().apply(points.reshape(-1, 3)).reshape(points.shape)) is not None:
            pose = np.concatenate([np.zeros(3), turn.as_quat()])
            return OPTICAL if turn.magnitude() < 1e-6 else SensorFrame(pose, _axes_in_words(turn))
    return None


def _frame(axes: str, viewpoint: Array | None) -> SensorFrame:
    words, pose = AXES[axes]
    if viewpoint is None:
        return OPTICAL if axes == "optical" else SensorFrame(pose, f"of the sensor, {words}")
    return SensorFrame(compose(viewpoint, pose), f"of a world, seen from VIEWPOINT ({words})")


def _nearest(frames: list[SensorFrame], points: Array, shape: Shape) -> SensorFrame | None:
    """The frame along whose z the points lie, the first where others are no better; a picture's is exact."""
    read = points[np.isfinite(points).all(axis=1) & points.any(axis=1)]
    if shape is not None:
        for frame in frames:
            if fitted_intrinsics(frame.seen(points).reshape(*shape, 3)) is not None:
                return frame
        if frames and frames[0] is OPTICAL and (turned := turned_frame(points.reshape(*shape, 3))):
            return turned
    found, best = None, -1.0
    for frame in frames:
        seen = frame.seen(read)
        away = np.linalg.norm(seen, axis=1)
        along = float(np.median(seen[:, 2] / np.maximum(away, 1e-9)))
        if np.mean(seen[:, 2] > 0) >= AHEAD and along > best + CLEARLY:
            found, best = frame, along
    return found


def _axes_in_words(turn: Rotation) -> str:
    """Which way the cloud's own axes point, as of a sensor's frame."""
    ways = np.array([["right", "left"], ["down", "up"], ["forward", "towards the sensor"]])
    rows = turn.as_matrix().round().astype(int)
    words = [ways[k, int(row[k] < 0)] for row in rows for k in [int(np.argmax(np.abs(row)))]]
    return "of the sensor, " + ", ".join(f"{axis} {word}" for axis, word in zip("xyz", words, strict=True))
