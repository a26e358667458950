"""Poses of a box that look the same, or lie flat."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, angle_between, quaternion_multiply, rotate

ALIKE = 0.1
"""share by which two sides may differ and still be taken for each other: what a first view cannot measure."""
_TURNS = Rotation.create_group("O")


def turns(size: Array) -> Array:
    """(G, 4) the turns after which a box of ``size`` (3,) looks the same; the identity among them."""
    after = np.abs(_TURNS.as_matrix()) @ size
    same = np.all(np.abs(after - size) <= ALIKE * np.maximum(after, size), axis=1)
    return np.asarray(_TURNS.as_quat()[same])


def nearest_alike(pose: Array, size: Array, to: Array) -> Array:
    """``pose`` (7,) turned so that a box of ``size`` looks the same and is turned least from ``to`` (7,)."""
    alike = quaternion_multiply(pose[3:], turns(size))
    return np.concatenate([pose[:3], alike[np.argmin(angle_between(alike, to))]])


def tilt(pose: Array) -> tuple[float, Array]:
    """Radians by which the box's most upright axis leans, and the (4,) turn that rights it."""
    up = rotate(pose[3:], np.eye(3))
    k = int(np.argmax(np.abs(up[:, 2])))
    axis = up[k] * np.sign(up[k, 2])
    across = np.array([axis[1], -axis[0], 0.0])
    sine = float(np.linalg.norm(across))
    angle = float(np.arctan2(sine, axis[2]))
    return angle, Rotation.from_rotvec(across / max(sine, 1e-12) * angle).as_quat()


def flat(pose: Array) -> Array:
    """The pose (7,) with the box's most upright axis vertical."""
    return np.concatenate([pose[:3], quaternion_multiply(tilt(pose)[1], pose[3:])])


def half_height(pose: Array, size: Array) -> float:
    """Metres from the box's centre to its lowest point."""
    return float(np.abs(rotate(pose[3:], np.eye(3))[:, 2]) @ size / 2)
