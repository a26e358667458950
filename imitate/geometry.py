"""Poses and frames.

A pose is an array (..., 7): x y z in metres, then a unit quaternion qx qy qz qw. A transform's name reads as
its composition: ``world_from_camera`` maps points in the camera's frame to the world's.
All functions are vectorised over the leading dimensions and never change their input.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

IDENTITY: Array = np.array([0.0, 0, 0, 0, 0, 0, 1])
IDENTITY.flags.writeable = False
NEARLY = 0.01
"""off one by which a quaternion's length may be, rounded in a file or kept in single precision."""
_EXACT = 1e-9


def read_only(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only, contiguous copy of ``values`` (the same object when it is one already)."""
    array: NDArray[Any] = np.asarray(values, dtype=dtype)
    if array.flags.writeable or not array.flags.c_contiguous:
        array = np.array(array, dtype=dtype, order="C")
        array.flags.writeable = False
    return array


def quaternion_multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Hamilton product a⊗b of quaternions (..., 4), x y z w."""
    ax, ay, az, aw = np.moveaxis(np.asarray(a, float), -1, 0)
    bx, by, bz, bw = np.moveaxis(np.asarray(b, float), -1, 0)
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def conjugate(quaternion: ArrayLike) -> Array:
    """The inverse rotation of unit quaternions (..., 4)."""
    inverted: Array = np.asarray(quaternion, float) * np.array([-1.0, -1, -1, 1])
    return inverted


def rotate(quaternion: ArrayLike, vectors: ArrayLike) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    q, v = np.asarray(quaternion, float), np.asarray(vectors, float)
    u, w = q[..., :3], q[..., 3:]
    t = 2 * np.cross(u, v)
    turned: Array = v + w * t + np.cross(u, t)
    return turned


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """The pose a∘b: b is given in a's frame, the result in the frame that a is given in."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    position = a[..., :3] + rotate(a[..., 3:], b[..., :3])
    return np.concatenate([position, quaternion_multiply(a[..., 3:], b[..., 3:])], axis=-1)


def inverse(pose: ArrayLike) -> Array:
    """The pose that undoes ``pose``."""
    pose = np.asarray(pose, float)
    turned = conjugate(pose[..., 3:])
    return np.concatenate([-rotate(turned, pose[..., :3]), turned], axis=-1)


def relative(reference: ArrayLike, pose: ArrayLike) -> Array:
    """``pose`` expressed in the frame of ``reference``; both given in the same frame."""
    return compose(inverse(reference), pose)


def align_signs(poses: ArrayLike, to: ArrayLike | None = None) -> Array:
    """Poses (T, 7) whose quaternions keep to one hemisphere along the trajectory.

    q and −q are the same rotation; a flip between two frames would read as a jump.

    Args:
        poses: (T, 7).
        to: (7,) or (4,), aligns the first quaternion with this one's; else the first is kept.
    """
    poses = np.array(poses, float)
    q = poses[:, 3:]
    first = np.asarray(q[0] if to is None else to, float)[-4:]
    steps = np.concatenate([[first @ q[0]], np.einsum("ij,ij->i", q[1:], q[:-1])])
    signs = np.cumprod(np.where(steps < 0, -1.0, 1.0))
    poses[:, 3:] = q * signs[:, None]
    return poses


def normalised(poses: ArrayLike) -> Array:
    """Poses (..., 7) with their quaternions scaled to length one."""
    poses = np.array(poses, float)
    poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=-1, keepdims=True)
    return poses


def nearly_normalised(poses: ArrayLike) -> Array:
    """Poses (..., 7), their quaternions of nearly length one scaled to it, and others as they are."""
    given = np.asarray(poses, float)
    with np.errstate(over="ignore"):
        off = np.abs(np.linalg.norm(given[..., 3:], axis=-1) - 1)
    rounded = (off > _EXACT) & (off < NEARLY)
    if not rounded.any():
        return given
    scaled = given.copy()
    scaled[rounded] = normalised(scaled[rounded])
    return scaled


def angle_between(a: ArrayLike, b: ArrayLike) -> Array:
    """The angle in radians, 0…π, between the orientations of poses or quaternions (..., 7 or 4)."""
    product = quaternion_multiply(conjugate(np.asarray(a, float)[..., -4:]), np.asarray(b, float)[..., -4:])
    return np.asarray(2 * np.arctan2(np.linalg.norm(product[..., :3], axis=-1), np.abs(product[..., 3])))


def from_yaw(position: ArrayLike, yaw: ArrayLike) -> Array:
    """Poses (..., 7) at ``position`` (..., 3), turned by ``yaw`` radians about z."""
    half = np.asarray(yaw, float) / 2
    zero = np.zeros_like(half)
    return np.concatenate(
        [np.asarray(position, float), np.stack([zero, zero, np.sin(half), np.cos(half)], axis=-1)], axis=-1
    )


def resample(t: ArrayLike, poses: ArrayLike, at: ArrayLike) -> Array:
    """Pose trajectories at other times: positions linearly, orientations along the great arc.

    Args:
        t: (T,) strictly increasing seconds, irregular steps allowed.
        poses: (T, ..., 7).
        at: (S,) seconds, within [t[0], t[-1]] (clamped otherwise).

    Returns:
        (S, ..., 7)
    """
    t, poses, at = np.asarray(t, float), np.asarray(poses, float), np.asarray(at, float)
    if len(t) == 1:
        return np.repeat(poses, len(at), axis=0)
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    u = np.clip((at - t[k]) / (t[k + 1] - t[k]), 0, 1).reshape(-1, *([1] * (poses.ndim - 1)))
    a, b = poses[k], poses[k + 1]
    qa, qb = a[..., 3:], b[..., 3:]
    dot = np.sum(qa * qb, axis=-1, keepdims=True)
    qb = np.where(dot < 0, -qb, qb)
    angle = np.arccos(np.clip(np.abs(dot), 0, 1))
    small = angle < 1e-6
    safe = np.where(small, 1.0, np.sin(angle))
    wa = np.where(small, 1 - u, np.sin((1 - u) * angle) / safe)
    wb = np.where(small, u, np.sin(u * angle) / safe)
    return normalised(np.concatenate([(1 - u) * a[..., :3] + u * b[..., :3], wa * qa + wb * qb], axis=-1))
