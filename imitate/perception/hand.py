"""The hand from its two coloured fingers: cylinders of known radius and length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, compose, normalised
from imitate.perception.colour import is_hue
from imitate.perception.shapes import Float, Pixels, agreement, cylinder_depth
from imitate.settings import Perception

SIDES = (-1, 1)
"""left and right, along the hand's y."""
SLACK = 0.01
"""m around a finger in which it is compared with what was seen."""
FEWEST = 12
"""pixels of a finger from which it counts as seen."""


@dataclass(frozen=True)
class Hand:
    """Where the hand is: its (7,) tool-centre point, and the distance between the fingers' surfaces."""

    pose: Array
    opening: float


def finger_poses(hands: Array, openings: Array, settings: Perception, side: int) -> Array:
    """(N, 7) middles of the left (side −1) or right (+1) fingers' cylinders, their z along the hand's."""
    offsets = np.zeros((len(hands), 7))
    offsets[:, 1] = side * (openings / 2 + settings.finger_radius)
    offsets[:, 2] = -settings.finger_length / 2
    offsets[:, 6] = 1
    return compose(hands, offsets)


def hand_of_pixels(pixels: Pixels, settings: Perception) -> Hand | None:
    """The hand as the two fingers' pixels show it, or None where one is not seen (the paper, Appendix A).

    z along the mean of the cylinders' axes, y from the left to the right one, x = y × z. The axes are fitted
    with the known radius; the tips are their lower ends.
    """
    fits = []
    for name in (settings.left_finger, settings.right_finger):
        kept = is_hue(pixels.hue, name) & (pixels.depth > 0)
        if kept.sum() < FEWEST:
            return None
        fits.append(_fit_axis(pixels.where(kept), settings))
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


def hand_score(fingers: tuple[Pixels, Pixels], hands: Array, openings: Array, settings: Perception) -> Float:
    """(N,) log-likelihood of the pixels around left and right for N hands (N, 7) and openings (N,)."""
    total = np.zeros(len(hands), np.float32)
    for pixels, side, name in zip(fingers, SIDES, (settings.left_finger, settings.right_finger), strict=True):
        poses = finger_poses(hands, openings, settings, side)
        depth = cylinder_depth(pixels, poses, settings.finger_radius, settings.finger_length)
        total += agreement(pixels, is_hue(pixels.hue, name), depth, settings.depth_noise)
    return total


def around_finger(pixels: Pixels, hands: Array, openings: Array, settings: Perception, side: int) -> Pixels:
    """Those pixels that show the finger of one of some hands, or the space within `SLACK` of it."""
    poses = finger_poses(hands, openings, settings, side)
    size = settings.finger_radius + SLACK, settings.finger_length + 2 * SLACK
    hit = np.isfinite(cylinder_depth(pixels, poses, *size))
    return pixels.where(np.asarray(hit.any(axis=0)))


def _fit_axis(pixels: Pixels, settings: Perception) -> tuple[Array, Array]:
    """(tip, direction) of the cylinder through one finger's pixels; the direction points downwards."""
    points = pixels.points()
    points = points[np.linalg.norm(points - np.median(points, axis=0), axis=1) < settings.finger_length]
    middle = points.mean(axis=0)
    direction = np.linalg.svd((points - middle).T @ (points - middle))[0][:, 0]
    direction = direction if direction[2] < 0 else -direction
    sight = middle - pixels.origin
    across = np.cross(direction, sight)
    inwards = np.cross(across, direction)
    inwards /= np.linalg.norm(inwards)
    # Points spread evenly over the half that faces the camera lie π/4 of the radius before the axis.
    middle = middle + inwards * settings.finger_radius * np.pi / 4
    along = (points - middle) @ direction
    return middle + direction * np.percentile(along, 98), direction
