"""The virtual RGB-D camera: PyBullet's software renderer behind a Kinect's intrinsics and sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, read_only, rotate
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.world.engine import pybullet as bullet
from imitate.world.sensor import AXIAL, Sensor, read_depth

NEAR, FAR = 0.2, 4.0
"""m, the range in which something is drawn."""
LAMP = 2.5
"""m from what it lights to a lamp whose shadows are drawn."""
LAMP_PIXELS = 320
"""sides of the picture that is drawn from the lamp's place."""
SPOT = 0.6
"""m around what it is aimed at that a lamp's shadows are drawn in."""
BIAS = 0.01
"""m behind what the lamp sees first, from which a point lies in shadow."""

Window = tuple[int, int, int, int]
"""left, upper, right, lower in pixels; the last two exclusive."""


@dataclass(frozen=True)
class Camera:
    """A camera and where it stands; ``world_from_camera`` is (7,), x right, y down, z forward."""

    intrinsics: Intrinsics
    world_from_camera: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "world_from_camera", read_only(self.world_from_camera))


@dataclass(frozen=True)
class Light:
    """One lamp, by PyBullet's coefficients.

    Attributes:
        direction: towards the lamp, any length.
        ambient, diffuse, specular: shares of a surface's colour that it gives back.
        shade: share of its light that is left in its shadow; 1: it casts none.
    """

    direction: tuple[float, float, float] = (-0.4, 0.6, 1.5)
    ambient: float = 0.6
    diffuse: float = 0.5
    specular: float = 0.0
    shade: float = 1.0


@dataclass(frozen=True)
class View:
    """A picture without noise: (H, W, 3) colour 0…255, (H, W) metres, (H, W) PyBullet's body or −1."""

    colour: NDArray[np.float32]
    depth: Array
    body: NDArray[np.int32]


def kinect_intrinsics(width: int, height: int) -> Intrinsics:
    """A Kinect's 525 pixels at 640×480, scaled by the width; square pixels, the axis through the middle."""
    focal = 525.0 * width / 640
    return Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def looking_at(eye: Array, target: Array, roll: float = 0.0) -> Array:
    """(7,) a camera's pose at ``eye``, looking at ``target``, turned by ``roll`` radians about its axis."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(forward, right), forward], axis=1)
    turned = Rotation.from_matrix(axes) * Rotation.from_euler("z", roll)
    return np.concatenate([eye, turned.as_quat()])


def take(
    client: int, camera: Camera, t: float, generator: np.random.Generator, sensor: Sensor = AXIAL
) -> RgbdFrame:
    """One frame of what stands in the physics ``client`` at the moment, stamped with ``t`` seconds."""
    view = render(client, camera, (Light(),))
    colour = view.colour.astype(np.uint8)
    return RgbdFrame(t, colour, read_depth(view.depth, colour, camera.intrinsics, sensor, generator))


def render(
    client: int,
    camera: Camera,
    lights: tuple[Light, ...],
    window: Window | None = None,
    aim: Array | None = None,
) -> View:
    """What an ideal camera sees, the mean over the lights.

    Args:
        client: PyBullet's.
        camera: which.
        lights: at least one.
        window: the part of the picture that is drawn; None: all of it.
        aim: (3,) what the lamps' shadows are drawn around; None: no shadows.
    """
    i = camera.intrinsics
    left, upper, right, lower = window or (0, 0, i.width, i.height)
    part = Intrinsics(right - left, lower - upper, i.fx, i.fy, i.cx - left, i.cy - upper)
    inner = Camera(part, camera.world_from_camera)
    views = [_draw(client, inner, light) for light in lights]
    total = np.zeros_like(views[0].colour)
    for light, view in zip(lights, views, strict=True):
        total += view.colour
        if light.shade < 1 and aim is not None:
            hidden = _in_shadow(client, _points(inner, view.depth), light, aim)
            total[hidden] -= np.float32(1 - light.shade) * view.colour[hidden]
    return View(total / np.float32(len(lights)), views[0].depth, views[0].body)


def _points(camera: Camera, depth: Array) -> Array:
    """(H, W, 3) what each pixel shows, in the world."""
    pose = camera.world_from_camera
    axes = Rotation.from_quat(pose[3:]).as_matrix()
    return np.asarray(pose[:3] + (camera.intrinsics.rays() * depth[..., None]) @ axes.T)


def project(camera: Camera, points: Array) -> Array:
    """(N, 3) column, row and depth (pixels, pixels, metres) of points (N, 3) in the world."""
    i, pose = camera.intrinsics, camera.world_from_camera
    seen = (points - pose[:3]) @ Rotation.from_quat(pose[3:]).as_matrix()
    z = np.maximum(seen[..., 2], 1e-3)
    return np.stack([i.fx * seen[..., 0] / z + i.cx, i.fy * seen[..., 1] / z + i.cy, z], axis=-1)


def bodies_seen(client: int, camera: Camera) -> NDArray[np.int32]:
    """(H, W) PyBullet's body that each pixel shows, −1 for none."""
    return _draw(client, camera, Light()).body


def _in_shadow(client: int, points: Array, light: Light, aim: Array) -> NDArray[np.bool_]:
    """Which points (H, W, 3) the lamp does not reach: from its place something else is seen before them."""
    near = points.reshape(-1, 3)
    half = LAMP_PIXELS / 2
    focal = half * LAMP / SPOT
    i = Intrinsics(LAMP_PIXELS, LAMP_PIXELS, focal, focal, half - 0.5, half - 0.5)
    towards = np.array(light.direction) / np.linalg.norm(light.direction)
    lamp = Camera(i, looking_at(aim + LAMP * towards, aim))
    first = _draw(client, lamp, light).depth
    column, row, depth = np.moveaxis(project(lamp, near), -1, 0)
    u, v = np.round(column).astype(int), np.round(row).astype(int)
    inside = (u >= 0) & (u < LAMP_PIXELS) & (v >= 0) & (v < LAMP_PIXELS)
    hidden = inside.copy()
    hidden[inside] = depth[inside] > first[v[inside], u[inside]] + BIAS
    return np.asarray(hidden.reshape(points.shape[:-1]))


def _draw(client: int, camera: Camera, light: Light) -> View:
    i = camera.intrinsics
    _, _, rgba, buffer, body = bullet.getCameraImage(
        i.width,
        i.height,
        viewMatrix=_view(camera.world_from_camera),
        projectionMatrix=_projection(i),
        lightDirection=light.direction,
        lightAmbientCoeff=light.ambient,
        lightDiffuseCoeff=light.diffuse,
        lightSpecularCoeff=light.specular,
        shadow=0,
        renderer=bullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    colour = np.asarray(rgba, np.uint8).reshape(i.height, i.width, 4)[..., :3]
    drawn = np.asarray(buffer, np.float64).reshape(i.height, i.width)
    depth = FAR * NEAR / (FAR - (FAR - NEAR) * drawn)
    return View(colour.astype(np.float32), depth, np.asarray(body, np.int32).reshape(i.height, i.width))


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
