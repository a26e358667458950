"""What the room looks like: lamps, the table's colour and grain, a wall; drawn by chance."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, rotate
from imitate.world.kinect import Camera, Light

WAVES = 40
"""plane waves that make the table's grain."""


@dataclass(frozen=True)
class Look:
    """What the surroundings look like.

    Attributes:
        lights: at least one.
        table: red, green, blue 0…1.
        grain: contrast of the table's texture, 0: none.
        wall: metres from the middle of the performance to a wall behind it; 0: none.
        seed: of the texture.
        arm: whether a bare hand and a sleeve go with the fingers.
    """

    lights: tuple[Light, ...] = (Light(),)
    table: tuple[float, float, float] = (0.62, 0.58, 0.52)
    grain: float = 0.0
    wall: float = 0.0
    seed: int = 0
    arm: bool = False


def draw_look(generator: np.random.Generator) -> Look:
    """A room by chance: a wooden, grey or pale table, one or two lamps with shadows, mostly a wall."""
    lights = []
    for _ in range(generator.integers(1, 3)):
        around, up = generator.uniform(0, 2 * np.pi), generator.uniform(np.deg2rad(40), np.deg2rad(80))
        x, y, z = np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)
        ambient, diffuse = generator.uniform(0.45, 0.65), generator.uniform(0.35, 0.55)
        lights.append(
            Light((x, y, z), ambient, diffuse, generator.uniform(0, 0.3), generator.uniform(0.6, 0.9))
        )
    hue, saturation = generator.uniform(0.05, 0.15), generator.uniform(0, 0.3)
    table = colorsys.hsv_to_rgb(hue, saturation, generator.uniform(0.45, 0.85))
    wall = generator.uniform(0.7, 2.0) if generator.random() < 0.7 else 0.0
    return Look(tuple(lights), table, generator.uniform(0.03, 0.15), wall, int(generator.integers(2**31)))


def grain(camera: Camera, depth: Array, look: Look) -> NDArray[np.float32]:
    """(H, W) factors of the table's colour: many waves, stretched along the wood.

    Args:
        camera: sees the bare table.
        depth: (H, W) metres.
        look: contrast and seed.
    """
    pose = camera.world_from_camera
    points = pose[:3] + rotate(pose[3:], camera.intrinsics.rays() * depth[..., None])
    generator = np.random.default_rng(look.seed)
    total = np.zeros(depth.shape)
    along = generator.uniform(0, np.pi)
    for _ in range(WAVES):
        length = np.exp(generator.uniform(np.log(0.006), np.log(0.1)))
        turn = along + generator.normal(0, 0.15)
        phase = points[..., 0] * np.cos(turn) + points[..., 1] * np.sin(turn)
        total += np.sin(2 * np.pi * phase / length + generator.uniform(0, 2 * np.pi))
    return np.asarray(1 + look.grain * np.clip(total / np.sqrt(WAVES), -1.5, 1.5), np.float32)
