"""The camera before which trials run: what physics has just done, drawn in a server of its own.

Physics has neither paint nor light, and stays as it is whether it is watched or not. The camera stands
opposite the robot and knows where it stands, and so where the robot is in its picture.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from imitate.errors import SceneError
from imitate.geometry import Array
from imitate.record import SceneSpec
from imitate.rgbd import RgbdFrame
from imitate.world.body import load_body, pose_body
from imitate.world.engine import open_client, pybullet
from imitate.world.kinect import (
    Camera,
    Light,
    View,
    bodies_seen,
    kinect_intrinsics,
    looking_at,
    project,
    render,
)
from imitate.world.robot import robot_of
from imitate.world.sensor import KINECT, read_depth
from imitate.world.stage import AWAY, BLOCKS, colour_of, painted_box, paints, put, span

PAINTS = (*BLOCKS, "red", "yellow")
"""of objects in trials: there are no fingers that could be mistaken for the last two."""
BEARINGS, ELEVATIONS = np.deg2rad(np.linspace(-60, 60, 9)), np.deg2rad([45.0, 60.0])
"""rad from straight opposite the robot and above the table, of the places where the camera may stand."""
DISTANCE, SPREAD = 0.9, 2.5
"""m from the middle of the objects, at least; and for each that an object stands from it, how many more."""
AS_GOOD = 0.9
"""share of the best place's view of the worst hidden object, from which a place is as good as the best."""
TRIED = 160
"""pixels across, in which places are compared."""
TABLE = (2.0, 2.0, 0.04)
"""m, what is drawn around the objects."""
WOOD, GREY = (0.62, 0.58, 0.52), 128
"""the table's red, green and blue 0…1; what the robot's colours are replaced by, 0…255."""
LIGHTS = (Light(),)


class TrialCamera:
    """A scene's objects, each in a paint of its own, and its robot, before a Kinect.

    Attributes:
        camera: its intrinsics and its pose in the world.
        hues: (K) what each object is painted.
    """

    def __init__(self, spec: SceneSpec, width: int) -> None:
        self.hues = trial_paints(spec.object_names)
        self._client = open_client()
        self._robot = robot_of(spec)
        x, y, _ = spec.object_poses[:, :3].mean(axis=0)
        painted_box(self._client.number, TABLE, (x, y, -TABLE[2] / 2), WOOD)
        self._objects = [
            painted_box(self._client.number, size, (0, 0, -9), colour_of(hue))
            for size, hue in zip(spec.object_sizes, self.hues, strict=True)
        ]
        self._radii = np.linalg.norm(spec.object_sizes, axis=1) / 2
        flags = pybullet.URDF_ENABLE_CACHED_GRAPHICS_SHAPES
        self._body = load_body(self._client, self._robot, spec.base, flags)
        self.camera = Camera(kinect_intrinsics(width, width * 3 // 4), self._best_place(spec))
        self._place(spec.home, np.tile(AWAY, (len(self._objects), 1)))
        with self._without_robot():
            self._bare = render(self._client.number, self.camera, LIGHTS)

    def close(self) -> None:
        """Disconnects from the server."""
        self._client.disconnect()

    def picture(self, t: float, joints: Array, objects: Array, generator: np.random.Generator) -> RgbdFrame:
        """What a Kinect sees, but for the robot, which is known to be there: grey, at its true depth.

        A robot filters itself out of its pictures by its joints' positions; with the camera's place known
        exactly, what that gives is what the drawing says shows the robot.

        Args:
            t: seconds, the frame's stamp.
            joints: (J,) as in a record.
            objects: (K, 7) world poses.
            generator: of the sensor's noise.
        """
        self._place(joints, objects)
        view = self._view(objects)
        colour = view.colour.astype(np.uint8)
        depth = read_depth(view.depth, colour, self.camera.intrinsics, KINECT, generator)
        robot = view.body == self._body.number
        colour[robot], depth[robot] = GREY, view.depth[robot]
        return RgbdFrame(t, colour, depth)

    def _place(self, joints: Array, objects: Array) -> None:
        pose_body(self._client, self._body, self._robot, joints.tolist())
        for body, pose in zip(self._objects, objects, strict=True):
            put(self._client.number, body, pose)

    def _view(self, objects: Array) -> View:
        # Drawn around the objects; the rest is bare table: what more there is of the robot hides nothing.
        i = self.camera.intrinsics
        seen = project(self.camera, objects[:, :3])
        margin = 2 * self._radii * i.fx / seen[:, 2] + 3
        left, right = span(seen[:, 0], margin, i.width)
        upper, lower = span(seen[:, 1], margin, i.height)
        part = render(self._client.number, self.camera, LIGHTS, (left, upper, right, lower))
        colour, depth, body = self._bare.colour.copy(), self._bare.depth.copy(), self._bare.body.copy()
        inside = np.s_[upper:lower, left:right]
        colour[inside], depth[inside], body[inside] = part.colour, part.depth, part.body
        return View(colour, depth, body)

    def _best_place(self, spec: SceneSpec) -> Array:
        # (7,) where one would put the camera: the worst hidden object is hidden least by the waiting robot;
        # of places alike in that, the one from which the nearest two objects stand farthest apart sideways.
        places = [stand(spec, bearing, up) for up in ELEVATIONS for bearing in BEARINGS]
        shown = np.array([self._least_shown(spec, place) for place in places])
        apart = np.array([_sideways(spec, place) for place in places])
        return places[int(np.argmax(np.where(shown >= AS_GOOD * shown.max(), apart, -1)))]

    def _least_shown(self, spec: SceneSpec, place: Array) -> float:
        # The least share of an object's pixels that the robot leaves.
        camera = Camera(kinect_intrinsics(TRIED, TRIED * 3 // 4), place)
        self._place(spec.home, spec.object_poses)
        left = bodies_seen(self._client.number, camera)
        with self._without_robot():
            whole = bodies_seen(self._client.number, camera)
        return min(float((left == b).sum() / max((whole == b).sum(), 1)) for b in self._objects)

    @contextmanager
    def _without_robot(self) -> Iterator[None]:
        number = self._body.number
        position, turn = self._client.getBasePositionAndOrientation(number)
        put(self._client.number, number, AWAY)
        yield
        put(self._client.number, number, np.array(position + turn))


def trial_paints(names: tuple[str, ...]) -> tuple[str, ...]:
    """What each object is painted in trials.

    Raises:
        SceneError: more objects than paints.
    """
    if len(names) > len(PAINTS):
        raise SceneError(
            f"{len(names)} objects, and {len(PAINTS)} paints by which the camera tells them apart. Leave "
            "some out of the demonstration, or learn without --observe-trials."
        )
    return paints(names) if len(names) <= len(BLOCKS) else PAINTS[: len(names)]


def stand(spec: SceneSpec, beside: float = 0.0, up: float = np.pi / 4) -> Array:
    """(7,) a camera behind the objects as the robot sees them, looking back and down on their middle.

    Args:
        spec: the scene.
        beside: rad from straight opposite the robot.
        up: rad above the table.
    """
    points = spec.object_poses[:, :3]
    target = points.mean(axis=0)
    ahead = target[:2] - spec.base[:2]
    bearing = np.arctan2(ahead[1], ahead[0]) + beside
    away = np.array([np.cos(up) * np.cos(bearing), np.cos(up) * np.sin(bearing), np.sin(up)])
    distance = DISTANCE + SPREAD * max(0.0, float(np.linalg.norm(points - target, axis=1).max()) - 0.1)
    return looking_at(target + distance * away, target)


def _sideways(spec: SceneSpec, place: Array) -> float:
    camera = Camera(kinect_intrinsics(TRIED, TRIED * 3 // 4), place)
    across = np.sort(project(camera, spec.object_poses[:, :3])[:, 0])
    return float(np.diff(across).min(initial=TRIED))
