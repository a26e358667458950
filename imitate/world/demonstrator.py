"""The virtual demonstrator: a performance, a place for the camera and a room, filmed frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from imitate.errors import SceneError
from imitate.geometry import Array
from imitate.rgbd import RgbdFrame
from imitate.settings import Perception
from imitate.world.kinect import Camera, kinect_intrinsics, looking_at
from imitate.world.look import Look
from imitate.world.performance import Performance
from imitate.world.sensor import AXIAL, Sensor, read_depth
from imitate.world.stage import middle, stage


@dataclass(frozen=True)
class Viewpoint:
    """Where the camera stands, from the middle of what is filmed.

    Attributes:
        azimuth: degrees about z, 0 on the side of −x, positive towards +y.
        elevation: degrees above the table.
        distance: metres.
        roll: degrees about the line of sight.
    """

    azimuth: float
    elevation: float
    distance: float
    roll: float = 0.0


FRONT = Viewpoint(7.9435, 47.8703, 0.647225)
"""0.43 m before, 0.06 m beside and 0.48 m above the middle."""


def draw_viewpoint(generator: np.random.Generator) -> Viewpoint:
    """A viewpoint by chance: to both sides, 30° to 70° high, 0.7 m to 1.2 m away, rolled a little."""
    return Viewpoint(
        azimuth=generator.uniform(-40, 40),
        elevation=generator.uniform(30, 70),
        distance=generator.uniform(0.7, 1.2),
        roll=generator.uniform(-8, 8),
    )


@dataclass(frozen=True)
class Film:
    """What is filmed: the performance at the frames' times, the camera in its frame, sensor and room."""

    performance: Performance
    camera: Camera
    sensor: Sensor = AXIAL
    look: Look = field(default_factory=Look)


def plan_film(
    performance: Performance,
    width: int,
    height: int,
    rate: float,
    viewpoint: Viewpoint = FRONT,
    sensor: Sensor = AXIAL,
    look: Look | None = None,
) -> Film:
    """The camera in front of the performance, and the frames at ``rate`` per second."""
    d = performance.demonstration
    frames = int(np.floor(d.duration * rate + 1e-9)) + 1
    camera = Camera(kinect_intrinsics(width, height), _stand(middle(performance), viewpoint))
    return Film(performance.at(d.t[0] + np.arange(frames) / rate), camera, sensor, look or Look())


def film(plan: Film, hand: Perception, seed: int) -> Iterator[RgbdFrame]:
    """Perform, and give what the camera sees, frame by frame.

    Args:
        plan: from `plan_film`.
        hand: hue, radius and length of the fingers.
        seed: of the camera's noise.

    Raises:
        SceneError: an object without a size, or more objects than there are paints.
    """
    d = plan.performance.demonstration
    if np.any(np.isnan(d.object_sizes)):
        raise SceneError("object_sizes: an object of unknown size cannot be filmed. Give its size in metres.")
    generator = np.random.default_rng(seed)
    with stage(plan.performance, plan.camera, hand, plan.look) as scene:
        for k, t in enumerate(d.t):
            view = scene.view(k)
            colour = view.colour.astype(np.uint8)
            depth = read_depth(view.depth, colour, plan.camera.intrinsics, plan.sensor, generator)
            yield RgbdFrame(float(t), colour, depth)


def visible(plan: Film, hand: Perception, frames: NDArray[np.intp]) -> Array:
    """(F, 1 + K) share of the pixels of hand and objects that nothing else hides from the camera.

    Args:
        plan: what is filmed.
        hand: the fingers.
        frames: (F,) indices of the performance's frames.

    The share is of the whole outline, within the picture or not.
    """
    with stage(plan.performance, plan.camera, hand, plan.look) as scene:
        return np.array([scene.shares(int(k)) for k in frames]).reshape(
            len(frames), len(plan.performance.demonstration.object_names) + 1
        )


def _stand(target: Array, viewpoint: Viewpoint) -> Array:
    """(7,) the camera's pose."""
    around, up = np.deg2rad([viewpoint.azimuth, viewpoint.elevation])
    away = np.array([-np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    return looking_at(target + viewpoint.distance * away, target, np.deg2rad(viewpoint.roll))
