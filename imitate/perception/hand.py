"""The hand from its two coloured fingers: cylinders of known radius and length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import IDENTITY, Array, compose, normalised, rotate
from imitate.perception.clusters import dense_parts
from imitate.perception.colour import FINGERS, is_hue
from imitate.perception.fingers import LEFT, RIGHT, is_finger
from imitate.perception.shapes import Pixels
from imitate.settings import Perception

SIDES = (LEFT, RIGHT)
NAMES = tuple(FINGERS)
"""of the left and the right finger."""
SLACK = 0.01
"""m around a finger in which it is compared with what was seen."""
FEWEST = 12
"""pixels of a finger from which it counts as seen."""


@dataclass(frozen=True)
class Hand:
    """Where the hand is: its (7,) tool-centre point, and the distance between the fingers' surfaces."""

    pose: Array
    opening: float


def finger_offsets(openings: Array, settings: Perception, side: int) -> Array:
    """(N, 3) the middles of the left (side −1) or right (+1) fingers' cylinders in the hands' frames."""
    offsets = np.zeros((len(openings), 3))
    offsets[:, 1] = side * (openings / 2 + settings.finger_radius)
    offsets[:, 2] = -settings.finger_length / 2
    return offsets


def finger_poses(hands: Array, openings: Array, settings: Perception, side: int) -> Array:
    """(N, 7) middles of the left (side −1) or right (+1) fingers' cylinders, their z along the hand's."""
    offsets = finger_offsets(openings, settings, side)
    return compose(hands, np.pad(offsets, ((0, 0), (0, 4))) + IDENTITY)


def hand_of_pixels(pixels: Pixels, settings: Perception, before: Hand | None = None) -> Hand | None:
    """The hand as the two fingers' pixels show it, or None where one is not seen (the paper, Appendix A).

    z along the mean of the cylinders' axes, y from the left to the right one, x = y × z. The axes are fitted
    with the known radius. The tips are their lower ends; where the hand was seen before, the ends that its z
    pointed to then, however it has been turned since.
    """
    tips = np.array([0, 0, -1.0]) if before is None else rotate(before.pose[3:], [0, 0, 1.0])
    fits = []
    for name in NAMES:
        kept = is_hue(pixels.hue, name) & (pixels.depth > 0)
        if kept.sum() < FEWEST:
            return None
        fits.append(_fit_axis(pixels.where(kept), settings, tips))
    (left, a), (right, b) = fits
    z = (a + b) / np.linalg.norm(a + b)
    y = right - left
    distance = float(np.linalg.norm(y - z * (y @ z)))
    if distance < 1e-3:
        return None
    y = (y - z * (y @ z)) / distance
    turn = Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=1)).as_quat()
    opening = max(distance - 2 * settings.finger_radius, 0.0)
    return Hand(normalised(np.concatenate([(left + right) / 2, turn])), opening)


def _fit_axis(pixels: Pixels, settings: Perception, tips: Array) -> tuple[Array, Array]:
    """(tip, direction) of the cylinder through one finger's pixels; the direction points as ``tips`` does."""
    points = _finger(pixels.points(), settings)
    middle = points.mean(axis=0)
    direction = np.linalg.svd((points - middle).T @ (points - middle))[0][:, 0]
    direction = direction if direction @ tips > 0 else -direction
    sight = middle - pixels.origin
    across = np.cross(direction, sight)
    inwards = np.cross(across, direction)
    inwards /= np.linalg.norm(inwards)
    # Points spread evenly over the half that faces the camera lie π/4 of the radius before the axis.
    middle = middle + inwards * settings.finger_radius * np.pi / 4
    along = (points - middle) @ direction
    return middle + direction * np.percentile(along, 98), direction


def _finger(points: Array, settings: Perception) -> Array:
    """Of the points (N, 3) of a finger's colour the largest part that could be one, metres."""
    parts: list[Array] = [points[part] for part in dense_parts(points, settings.finger_radius, 4)]
    likely = [part for part in parts if is_finger(part, settings, settings.depth_noise)]
    scattered = points[np.linalg.norm(points - np.median(points, axis=0), axis=1) < settings.finger_length]
    choices: list[Array] = [*likely, *parts, scattered]
    return choices[0]
