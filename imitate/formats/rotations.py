"""Orientations as other programs write them, as quaternions x y z w."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array


def rotation_width(order: str) -> int:
    """How many numbers an orientation takes that is written so (`mapping.RotationAs`)."""
    return 4 if order in ("xyzw", "wxyz") else 3


def quaternions(position: Array, turned: Array | None, order: str) -> Array:
    """(T, 4) x y z w of orientations that are written in ``order``; of none given, the identity.

    Args:
        position: (T, 3), NaN where not seen.
        turned: (T, 3) or (T, 4), or None.
        order: see `mapping.RotationAs`.
    """
    if turned is None:
        fixed = np.tile([0.0, 0, 0, 1], (len(position), 1))
        fixed[np.isnan(position).any(axis=1)] = np.nan
        return fixed
    if order in ("rotvec", "rpy"):
        seen = np.isfinite(turned).all(axis=1)
        angles = turned[seen]
        made = Rotation.from_rotvec(angles) if order == "rotvec" else Rotation.from_euler("xyz", angles)
        found = np.full((len(turned), 4), np.nan)
        found[seen] = made.as_quat()
        return found
    return turned[:, [1, 2, 3, 0]] if order == "wxyz" else turned
