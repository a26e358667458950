"""The virtual RGB-D camera: PyBullet's software renderer behind a Kinect's intrinsics and noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pybullet as bullet

from imitate.geometry import Array, read_only, rotate
from imitate.rgbd import Intrinsics, RgbdFrame

NEAR, FAR = 0.2, 4.0
"""m, the range in which something is drawn."""
SHORTEST, LONGEST = 0.4, 3.5
"""m, the range in which a Kinect gives a depth."""


@dataclass(frozen=True)
class Camera:
    """A camera and where it stands; ``world_from_camera`` is (7,), x right, y down, z forward."""

    intrinsics: Intrinsics
    world_from_camera: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "world_from_camera", read_only(self.world_from_camera))


def kinect_intrinsics(width: int, height: int) -> Intrinsics:
    """A Kinect's 525 pixels at 640×480, scaled by the width; square pixels, the axis through the middle."""
    focal = 525.0 * width / 640
    return Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def axial_noise(depth: Array) -> Array:
    """Standard deviation in metres of a Kinect's depth at ``depth`` metres (Nguyen et al. 2012)."""
    return np.asarray(0.0012 + 0.0019 * (np.asarray(depth) - 0.4) ** 2)


def take(client: int, camera: Camera, t: float, generator: np.random.Generator) -> RgbdFrame:
    """One frame of what stands in the physics ``client`` at the moment, stamped with ``t`` seconds."""
    i = camera.intrinsics
    _, _, rgba, buffer, _ = bullet.getCameraImage(
        i.width,
        i.height,
        viewMatrix=_view(camera.world_from_camera),
        projectionMatrix=_projection(i),
        lightDirection=(-0.4, 0.6, 1.5),
        lightAmbientCoeff=0.6,
        lightDiffuseCoeff=0.5,
        lightSpecularCoeff=0.0,
        shadow=0,
        renderer=bullet.ER_TINY_RENDERER,
        flags=bullet.ER_NO_SEGMENTATION_MASK,
        physicsClientId=client,
    )
    colour = np.asarray(rgba, np.uint8).reshape(i.height, i.width, 4)[..., :3]
    drawn = np.asarray(buffer, np.float64).reshape(i.height, i.width)
    depth = FAR * NEAR / (FAR - (FAR - NEAR) * drawn)
    depth += axial_noise(depth) * generator.standard_normal(depth.shape)
    depth[(depth < SHORTEST) | (depth > LONGEST)] = 0
    return RgbdFrame(t, colour, depth.astype(np.float32))


def _view(world_from_camera: Array) -> list[float]:
    eye, quaternion = world_from_camera[:3], world_from_camera[3:]
    down, forward = rotate(quaternion, [0, 1.0, 0]), rotate(quaternion, [0, 0, 1.0])
    matrix: list[float] = list(bullet.computeViewMatrix(eye, eye + forward, -down))
    return matrix


def _projection(i: Intrinsics) -> list[float]:
    """OpenGL's matrix, column by column; this renderer samples a pixel at its lower left corner."""
    columns = np.zeros((4, 4))
    columns[0, 0], columns[1, 1] = 2 * i.fx / i.width, 2 * i.fy / i.height
    columns[2, :2] = 1 - 2 * i.cx / i.width, 2 * (i.cy + 1) / i.height - 1
    columns[2, 2:] = -(FAR + NEAR) / (FAR - NEAR), -1
    columns[3, 2] = -2 * FAR * NEAR / (FAR - NEAR)
    flat: list[float] = columns.ravel().tolist()
    return flat
