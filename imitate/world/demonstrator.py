"""The virtual human hand: two coloured fingers and coloured blocks, moved in front of the virtual camera."""

from __future__ import annotations

import colorsys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.demonstration import Demonstration
from imitate.errors import SceneError
from imitate.geometry import IDENTITY, Array, compose
from imitate.rgbd import RgbdFrame
from imitate.settings import Perception
from imitate.world.performance import Performance
from imitate.world.quiet import quiet

with quiet(1, 2):
    import pybullet as bullet

    from imitate.world.kinect import Camera, kinect_intrinsics, take

HUES = {"red": 0, "yellow": 54, "green": 125, "cyan": 180, "blue": 225, "purple": 280}
"""degrees, of the paints that the demonstrator has."""
BLOCKS = ("blue", "green", "purple", "cyan")
"""paints of the blocks, the first object first."""
TABLE = (0.8, 0.9, 0.04)
"""m: length away from the camera, width, thickness."""
FACETS = 36
"""of a finger's cylinder."""
FLOOR = 0.75
"""m below the table's top."""


@dataclass(frozen=True)
class Film:
    """What is filmed: the performance at the frames' times, and the camera in the performance's frame."""

    performance: Performance
    camera: Camera


def plan_film(performance: Performance, width: int, height: int, rate: float) -> Film:
    """The camera in front of the performance, and the frames at ``rate`` per second."""
    d = performance.demonstration
    frames = int(np.floor(d.duration * rate + 1e-9)) + 1
    return Film(
        performance.at(d.t[0] + np.arange(frames) / rate),
        Camera(kinect_intrinsics(width, height), _stand(_middle(d))),
    )


def film(plan: Film, hand: Perception, seed: int) -> Iterator[RgbdFrame]:
    """Perform, and give what the camera sees, frame by frame.

    Args:
        plan: from `plan_film`.
        hand: hue, radius and length of the fingers.
        seed: of the camera's noise.

    Raises:
        SceneError: an object without a size, or more objects than there are paints.
    """
    d, opening = plan.performance.demonstration, plan.performance.opening
    if np.any(np.isnan(d.object_sizes)):
        raise SceneError("object_sizes: an object of unknown size cannot be filmed. Give its size in metres.")
    if len(d.object_names) > len(BLOCKS):
        raise SceneError(f"{len(d.object_names)} objects, and paint for {len(BLOCKS)}. Leave some out.")
    generator = np.random.default_rng(seed)
    with _set(d, hand) as (client, blocks, fingers):
        for k, t in enumerate(d.t):
            for body, pose in zip(blocks, d.objects[k], strict=True):
                bullet.resetBasePositionAndOrientation(body, pose[:3], pose[3:], physicsClientId=client)
            for body, side in zip(fingers, (-1, 1), strict=True):
                pose = compose(d.hand[k], _finger(side, float(opening[k]), hand))
                bullet.resetBasePositionAndOrientation(body, pose[:3], pose[3:], physicsClientId=client)
            yield take(client, plan.camera, float(t), generator)


def _finger(side: int, opening: float, hand: Perception) -> Array:
    """(7,) the middle of a finger's cylinder in the hand's frame: its tip at the tool-centre point's z."""
    pose = np.array(IDENTITY)
    pose[1:3] = side * (opening / 2 + hand.finger_radius), -hand.finger_length / 2
    return pose


def _middle(d: Demonstration) -> Array:
    """(3,) the middle of the space that the performance takes up."""
    points = np.concatenate([d.hand[:, :3], d.objects[..., :3].reshape(-1, 3)])
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def _stand(target: Array) -> Array:
    """(7,) the camera's pose: 0.65 m from the middle, looking along +x and down."""
    away = np.array([-0.43, 0.06, 0.48])
    forward = -away / np.linalg.norm(away)
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(forward, right), forward], axis=1)
    return np.concatenate([target + away, Rotation.from_matrix(axes).as_quat()])


@contextmanager
def _set(d: Demonstration, hand: Perception) -> Iterator[tuple[int, list[int], list[int]]]:
    """Table, floor, blocks and fingers in a fresh physics client: (client, blocks, fingers)."""
    client = bullet.connect(bullet.DIRECT)
    try:
        x, y, _ = _middle(d)
        _block(client, TABLE, (x, y, -TABLE[2] / 2), (0.62, 0.58, 0.52))
        _block(client, (6, 6, 0.02), (x, y, -FLOOR), (0.35, 0.36, 0.38))
        blocks = [_block(client, size, (0, 0, 0), _paint(BLOCKS[k])) for k, size in enumerate(d.object_sizes)]
        fingers = [_cylinder(client, hand, _paint(hue)) for hue in (hand.left_finger, hand.right_finger)]
        yield client, blocks, fingers
    finally:
        bullet.disconnect(client)


def _paint(name: str) -> tuple[float, float, float]:
    if name not in HUES:
        raise SceneError(f"no {name} paint for a finger. There is {', '.join(HUES)}.")
    return colorsys.hsv_to_rgb(HUES[name] / 360, 0.85, 0.85)


def _block(
    client: int, size: Array | tuple[float, ...], at: tuple[float, ...], colour: tuple[float, ...]
) -> int:
    shape = bullet.createVisualShape(
        bullet.GEOM_BOX,
        halfExtents=[float(s) / 2 for s in size],
        rgbaColor=[*colour, 1],
        physicsClientId=client,
    )
    body: int = bullet.createMultiBody(0, -1, shape, at, physicsClientId=client)
    return body


def _cylinder(client: int, hand: Perception, colour: tuple[float, ...]) -> int:
    """A finger as a mesh: PyBullet draws its own cylinders a millimetre too large."""
    angles = np.linspace(0, 2 * np.pi, FACETS, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    end = np.array([0, 0, hand.finger_length / 2])
    rim = hand.finger_radius * ring
    k = np.arange(FACETS)
    n = np.roll(k, -1)
    side = [[k, n, n + FACETS], [k, n + FACETS, k + FACETS]]
    caps = [[0 * k + 4 * FACETS, n + 2 * FACETS, k + 2 * FACETS]]
    caps += [[0 * k + 4 * FACETS + 1, k + 3 * FACETS, n + 3 * FACETS]]
    up = np.broadcast_to([0, 0, 1.0], (FACETS, 3))
    shape = bullet.createVisualShape(
        bullet.GEOM_MESH,
        vertices=np.concatenate([rim - end, rim + end, rim - end, rim + end, [-end, end]]).tolist(),
        indices=np.concatenate([np.stack(t, axis=1).reshape(-1) for t in side + caps]).tolist(),
        normals=np.concatenate([ring, ring, -up, up, [[0, 0, -1], [0, 0, 1]]]).tolist(),
        rgbaColor=[*colour, 1],
        physicsClientId=client,
    )
    body: int = bullet.createMultiBody(0, -1, shape, physicsClientId=client)
    return body
