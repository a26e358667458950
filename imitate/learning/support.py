"""What stands on what, by the boxes that objects are, and what hangs in the air."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.geometry import Array, resample, rotate

TOUCHING = 0.005
"""m between an object's lower side and another's upper one, below which it stands on it."""
IN_AIR = 0.01
"""m between what is shown to be held and anything below it, above which it hangs."""


def standing_on(poses: Array, sizes: Array, touching: float = TOUCHING) -> NDArray[np.intp]:
    """(K,) the index of the object that each stands on; −1 where there is none.

    Args:
        poses: (K, 7) in the world.
        sizes: (K, 3) m.
        touching: m that may lie between.
    """
    bottom, top, reach = _extent(poses, sizes)
    across = np.linalg.norm(poses[:, None, :2] - poses[None, :, :2], axis=-1)
    stands = (np.abs(bottom[:, None] - top[None, :]) < touching) & (across < reach[None, :])
    return np.where(stands.any(axis=1), np.argmax(stands, axis=1), -1)


def hang_in_air(demonstration: Demonstration, names: Sequence[str], time: float) -> tuple[str, ...]:
    """Which of these objects stand neither on the table nor on another; none of unknown size does.

    Args:
        demonstration: in the table frame, every pose known.
        names: of objects.
        time: s since the first frame.
    """
    d = demonstration
    poses = resample(d.t - d.t[0], d.objects, [time])[0]
    on = standing_on(poses, d.object_sizes, IN_AIR)
    bottom, _, _ = _extent(poses, d.object_sizes)
    found = ((name, d.object_names.index(name)) for name in names)
    return tuple(name for name, k in found if on[k] < 0 and bottom[k] > IN_AIR)


def _extent(poses: Array, sizes: Array) -> tuple[Array, Array, Array]:
    # (K,) lowest and highest z of boxes, and how far they get from their centres across, m.
    axes = rotate(poses[:, None, 3:], np.eye(3)[None] * sizes[:, None] / 2)  # (K, 3, 3) half edges
    half = np.abs(axes[..., 2]).sum(axis=1)
    reach = np.linalg.norm(np.abs(axes).sum(axis=1)[:, :2], axis=1)
    return poses[:, 2] - half, poses[:, 2] + half, reach
