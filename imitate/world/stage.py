"""What stands in front of the virtual camera: table, floor, wall, lamps, painted objects and two fingers."""

from __future__ import annotations

import colorsys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.errors import SceneError
from imitate.geometry import IDENTITY, Array, compose
from imitate.rgbd import Intrinsics
from imitate.settings import Perception
from imitate.world.engine import pybullet as bullet
from imitate.world.kinect import Camera, View, Window, bodies_seen, project, render
from imitate.world.look import Look, grain
from imitate.world.performance import WALL, Performance

HUES = {"red": 0, "yellow": 54, "green": 125, "cyan": 180, "blue": 225, "purple": 280}
"""degrees, of the paints that the demonstrator has."""
BLOCKS = ("blue", "green", "purple", "cyan")
"""paints of objects, the first object first; an object that is called like one of them wears that."""
TABLE = (0.8, 0.9, 0.04)
"""m: length away from the camera, width, thickness."""
AWAY = np.array([0, 0, -9.0, 0, 0, 0, 1])
"""where nothing is seen."""
COARSE = 3
"""times fewer pixels to a side when only outlines are compared."""
LEAST = 8
"""pixels, the least side of what is drawn."""
SIDES = (-1, 1)
"""left and right finger, along the hand's y."""
PALM, FOREARM = (0.03, 0.085, 0.08), (0.07, 0.08, 0.3)
"""m: thickness, width and length."""
ELBOW = (0.8, 0.0, 0.6)
"""from the wrist: towards a person opposite the camera, and up."""
SKIN, SLEEVE = (0.80, 0.60, 0.48), (0.25, 0.27, 0.33)
"""red, green, blue 0…1."""
FACETS = 36
"""of a finger's cylinder."""
FLOOR = 0.75
"""m below the table's top."""


class Stage:
    """Bodies in a physics client, and what was drawn of those that never move."""

    def __init__(self, client: int, performance: Performance, camera: Camera, hand: Perception, look: Look):
        self._client, self._performance, self._hand = client, performance, hand
        self._camera, self._look = camera, look
        d = performance.demonstration
        x, y, _ = middle(performance)
        self._table = painted_box(client, TABLE, (x, y, -TABLE[2] / 2), look.table)
        painted_box(client, (6, 6, 0.02), (x, y, -FLOOR), (0.35, 0.36, 0.38))
        if look.wall:
            away = np.array([x, y]) - camera.world_from_camera[:2]
            ahead = away / np.linalg.norm(away)
            place = [*(np.array([x, y]) + (look.wall + TABLE[0] / 2) * ahead), 0.5]
            turn = np.arctan2(ahead[1], ahead[0])
            wall = painted_box(client, (0.02, 6, 3), tuple(place), (0.75, 0.74, 0.7))
            put(client, wall, np.array([*place, 0, 0, np.sin(turn / 2), np.cos(turn / 2)]))
        self._still = render(client, camera, look.lights, None, middle(performance))
        self._texture = grain(camera, self._still.depth, look)
        self._objects = [
            (_tray if name in performance.hollow else painted_box)(client, size, (0, 0, -9), colour_of(paint))
            for name, size, paint in zip(d.object_names, d.object_sizes, paints(d.object_names), strict=True)
        ]
        hues = hand.left_finger, hand.right_finger
        self._fingers = [_cylinder(client, hand, colour_of(hue)) for hue in hues]
        parts = ((PALM, SKIN), (FOREARM, SLEEVE)) if look.arm else ()
        self._arm = [painted_box(client, size, (0, 0, -9), colour) for size, colour in parts]

    def place(self, k: int) -> None:
        """Everything where it is in frame ``k`` of the performance."""
        for body, pose in zip(self._objects, self._performance.demonstration.objects[k], strict=True):
            put(self._client, body, pose)
        for body, side in zip(self._fingers, SIDES, strict=True):
            put(self._client, body, self._finger(k, side))
        for body, pose in zip(self._arm, self._arm_poses(k), strict=True):
            put(self._client, body, pose)

    def view(self, k: int) -> View:
        """What an ideal camera sees in frame ``k``: drawn around what may have moved, the rest as before."""
        self.place(k)
        left, upper, right, lower = window = self._window(k)
        part = render(self._client, self._camera, self._look.lights, window, middle(self._performance))
        still = self._still
        colour, depth, body = still.colour.copy(), still.depth.copy(), still.body.copy()
        inside = np.s_[upper:lower, left:right]
        colour[inside], depth[inside], body[inside] = part.colour, part.depth, part.body
        if self._look.grain:
            colour *= np.where(body == self._table, self._texture, np.float32(1))[..., None]
        return View(np.clip(colour, 0, 255), depth, body)

    def shares(self, k: int) -> Array:
        """(1 + K,) share of the hand's and each object's outline that the camera sees in frame ``k``."""
        i, scale, wider = self._camera.intrinsics, 1 / COARSE, 3
        width, height = round(i.width * scale), round(i.height * scale)
        side, top = width * (wider - 1) // 2, height * (wider - 1) // 2
        wide = Intrinsics(
            wider * width, wider * height, i.fx * scale, i.fy * scale, i.cx * scale + side, i.cy * scale + top
        )
        camera = Camera(wide, self._camera.world_from_camera)
        self.place(k)
        inside = bodies_seen(self._client, camera)[top : top + height, side : side + width]
        groups = [self._fingers, *([body] for body in self._objects)]
        shown = [np.isin(inside, bodies).sum() for bodies in groups]
        whole = []
        for group in groups:
            self.place(k)
            for body in (*self._fingers, *self._objects, *self._arm):
                if body not in group:
                    put(self._client, body, AWAY)
            whole.append(np.isin(bodies_seen(self._client, camera), group).sum())
        return np.array(shown) / np.maximum(whole, 1)

    def _finger(self, k: int, side: int) -> Array:
        """(7,) the middle of a finger's cylinder in frame ``k``: its tip at the tool-centre point's z."""
        pose = np.array(IDENTITY)
        opening = float(self._performance.opening[k])
        pose[1:3] = side * (opening / 2 + self._hand.finger_radius), -self._hand.finger_length / 2
        return compose(self._performance.demonstration.hand[k], pose)

    def _arm_poses(self, k: int) -> list[Array]:
        """Palm and forearm in frame ``k``: behind the fingers, and from there back to a person opposite."""
        if not self._arm:
            return []
        hand = self._performance.demonstration.hand[k]
        back = -self._hand.finger_length
        palm = compose(hand, [0, 0, back - PALM[2] / 2, 0, 0, 0, 1])
        wrist = compose(hand, [0, 0, back - PALM[2], 0, 0, 0, 1])[:3]
        turn = Rotation.align_vectors([ELBOW, [0, 1, 0]], [[0, 0, 1], [0, 1, 0]])[0]
        elbow = np.array(ELBOW) / np.linalg.norm(ELBOW)
        return [palm, np.concatenate([wrist + FOREARM[2] / 2 * elbow, turn.as_quat()])]

    def _window(self, k: int) -> Window:
        """Around every object, finger and arm of frame ``k`` and their shadows on the table."""
        d, i = self._performance.demonstration, self._camera.intrinsics
        hand = [*(self._finger(k, side) for side in SIDES), *self._arm_poses(k)]
        centres = np.concatenate([d.objects[k], hand])[:, :3]
        lengths = [self._hand.finger_length + 0.02] * 2
        lengths += [float(np.linalg.norm(size)) for size in (PALM, FOREARM)[: len(self._arm)]]
        radii = np.append(np.linalg.norm(d.object_sizes, axis=1), lengths) / 2
        spots, reach = [centres], [radii]
        for light in self._look.lights:
            if light.shade < 1:
                x, y, z = light.direction
                spots.append(centres - centres[:, 2:] * np.array([x / z, y / z, 1]))
                reach.append(2 * radii)  # a shadow is longer than what casts it
        seen = project(self._camera, np.concatenate(spots))
        margin = np.concatenate(reach) * i.fx / seen[:, 2] + 3
        left, right = span(seen[:, 0], margin, i.width)
        upper, lower = span(seen[:, 1], margin, i.height)
        return left, upper, right, lower


def span(middles: Array, margins: Array, size: int) -> tuple[int, int]:
    """First and last pixel, of ``size``, around middles with margins, all in pixels."""
    first = int(np.clip((middles - margins).min(), 0, size - LEAST))
    return first, int(np.clip((middles + margins).max(), first + LEAST, size))


@contextmanager
def stage(performance: Performance, camera: Camera, hand: Perception, look: Look) -> Iterator[Stage]:
    """The stage in a physics client of its own.

    Raises:
        SceneError: more objects than paints, or a finger of a hue that there is no paint for.
    """
    client = bullet.connect(bullet.DIRECT)
    try:
        yield Stage(client, performance, camera, hand, look)
    finally:
        bullet.disconnect(client)


def middle(performance: Performance) -> Array:
    """(3,) the middle of the space that the performance takes up."""
    d = performance.demonstration
    points = np.concatenate([d.hand[:, :3], d.objects[..., :3].reshape(-1, 3)])
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def paints(names: tuple[str, ...]) -> tuple[str, ...]:
    """What each object is painted: as it is called, else by its place in the row.

    Raises:
        SceneError: more objects than paints.
    """
    if len(names) > len(BLOCKS):
        raise SceneError(f"{len(names)} objects, and paint for {len(BLOCKS)}. Leave some out.")
    return names if set(names) <= set(BLOCKS) else BLOCKS[: len(names)]


def colour_of(name: str) -> tuple[float, float, float]:
    """Red, green and blue 0…1 of a paint.

    Raises:
        SceneError: no such paint.
    """
    if name not in HUES:
        raise SceneError(f"no {name} paint for a finger. There is {', '.join(HUES)}.")
    return colorsys.hsv_to_rgb(HUES[name] / 360, 0.85, 0.85)


def put(client: int, body: int, pose: Array) -> None:
    """Moves a body to a pose (7,)."""
    bullet.resetBasePositionAndOrientation(body, pose[:3], pose[3:], physicsClientId=client)


def painted_box(
    client: int, size: Array | tuple[float, ...], at: tuple[float, ...], colour: tuple[float, ...]
) -> int:
    """A box of one colour that is seen and not touched: its size (3,), its middle, red green blue 0…1."""
    shape = bullet.createVisualShape(
        bullet.GEOM_BOX,
        halfExtents=[float(s) / 2 for s in size],
        rgbaColor=[*colour, 1],
        physicsClientId=client,
    )
    body: int = bullet.createMultiBody(0, -1, shape, at, physicsClientId=client)
    return body


def _tray(client: int, size: Array, at: tuple[float, ...], colour: tuple[float, ...]) -> int:
    """An open box of walls and a floor, each `WALL` thick."""
    x, y, z = size / 2
    w = WALL / 2
    halves = [(w, y, z), (w, y, z), (x - 2 * w, w, z), (x - 2 * w, w, z), (x - 2 * w, y - 2 * w, w)]
    places = [(w - x, 0, 0), (x - w, 0, 0), (0, w - y, 0), (0, y - w, 0), (0, 0, w - z)]
    shape = bullet.createVisualShapeArray(
        shapeTypes=[bullet.GEOM_BOX] * 5,
        halfExtents=halves,
        visualFramePositions=places,
        rgbaColors=[[*colour, 1]] * 5,
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
