"""Frames drawn from poses with the shapes that perception predicts by: table, coloured boxes and the hand."""

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import compose, inverse, rotate
from imitate.perception.hand import SIDES, finger_poses
from imitate.perception.shapes import box_nearness, cylinder_nearness, places
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception

INTRINSICS = Intrinsics(320, 240, 262.5, 262.5, 159.5, 119.5)
PAINT = {"blue": (30, 60, 210), "green": (30, 200, 50), "grey": (120, 120, 125)}
RED, YELLOW, WOOD = (210, 30, 30), (220, 200, 20), (150, 140, 128)
NOISE = 0.0015
"""m, standard deviation of depth."""


def camera():
    """(7,) world_from_camera: 0.65 m away, looking along x and down."""
    forward = np.array([0.62, 0, -0.78]) / np.hypot(0.62, 0.78)
    right = np.array([0.0, -1, 0])
    axes = np.stack([right, np.cross(forward, right), forward], axis=1)
    return np.concatenate([-0.65 * forward, Rotation.from_matrix(axes).as_quat()])


def frame(t, boxes, hand=None, generator=None, opening=0.06, board=None):
    """One frame at t seconds.

    Args:
        boxes: (colour, pose (7,), size (3,)) of each.
        hand: (7,) tool-centre point, or None.
        generator: of the depth's noise.
        board: (columns' slice, depth) that stands before everything, or None.
    """
    i, eye, settings = INTRINSICS, camera(), Perception()
    rays = rotate(eye[3:], i.rays().reshape(-1, 3)).astype(np.float32)
    layers = [(WOOD, -rays[:, 2] / eye[2])]
    layers += [
        (PAINT[c], box_nearness(eye[:3], rays, places(np.array([p])), np.array(s))[0]) for c, p, s in boxes
    ]
    if hand is not None:
        for side, paint in zip(SIDES, (RED, YELLOW), strict=True):
            pose = finger_poses(np.array([hand]), np.array([opening]), settings, side)
            radius, length = settings.finger_radius, settings.finger_length
            layers.append((paint, cylinder_nearness(eye[:3], rays, places(pose), radius, length)[0]))
    near = np.stack([n for _, n in layers])
    depth = (1 / near.max(axis=0)).reshape(i.height, i.width)
    colour = np.array([paint for paint, _ in layers], np.uint8)[near.argmax(axis=0)]
    colour = colour.reshape(i.height, i.width, 3)
    if generator is not None:
        depth = depth + NOISE * generator.standard_normal(depth.shape)
    if board is not None:
        colour[:, board[0]], depth[:, board[0]] = 70, board[1]
    return RgbdFrame(t, colour, depth.astype(np.float32))


class Drawn:
    """A source of frames: ``draw(k, generator)`` gives frame k; ``given`` counts them."""

    intrinsics = INTRINSICS

    def __init__(self, count, draw):
        self.count, self._draw, self.given = count, draw, 0

    def frames(self):
        generator = np.random.default_rng(1)
        for k in range(self.count):
            self.given += 1
            yield self._draw(k, generator)


def real(observation, poses):
    """``poses`` (..., 7) of this world in the observed table's frame: what should have been seen."""
    return compose(observation.first.table.table_from_camera, compose(inverse(camera()), poses))
