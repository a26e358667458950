"""Orientation as channels of a movement primitive: the quaternion itself, or its logarithm about the goal.

Seven channels are position and quaternion, renormalised afterwards (the paper). Six are position and
r = 2 log(q_g · q̄), a rotation vector that is 0 at the goal (Ude et al. 2014): it needs no renormalising, and
what is learned on it stays a rotation.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from imitate.geometry import Array, conjugate, normalised, quaternion_multiply

Orientation = Literal["quaternion", "log"]
CHANNELS: dict[Orientation, int] = {"quaternion": 7, "log": 6}


def to_channels(poses: Array, goal: Array, channels: int) -> Array:
    """Poses (..., 7) as channels (..., 7 or 6).

    Args:
        poses: their quaternions in one hemisphere with the goal's along the movement, so that turns of more
            than half a circle keep their way round.
        goal: (7,).
        channels: 7 or 6.
    """
    if channels == 7:
        return poses
    left = quaternion_multiply(goal[3:], conjugate(poses[..., 3:]))
    sine = np.linalg.norm(left[..., :3], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, left[..., 3:])
    axis = np.divide(left[..., :3], sine, out=np.zeros_like(left[..., :3]), where=sine > 0)
    return np.concatenate([poses[..., :3], axis * angle], axis=-1)


def to_poses(movement: Array, goal: Array) -> Array:
    """The inverse of `to_channels`, by the number of channels (..., 7 or 6)."""
    if movement.shape[-1] == 7:
        return normalised(movement)
    angle = np.linalg.norm(movement[..., 3:], axis=-1, keepdims=True)
    # sin(a/2)/a is 1/2 at 0, and np.sinc is sin(πx)/(πx).
    turn = np.concatenate([movement[..., 3:] * np.sinc(angle / (2 * np.pi)) / 2, np.cos(angle / 2)], axis=-1)
    return np.concatenate([movement[..., :3], quaternion_multiply(conjugate(turn), goal[3:])], axis=-1)
