"""Where trials start: as shown, with the objects moved and turned by chance."""

from __future__ import annotations

import numpy as np

from imitate.errors import ImitateError
from imitate.geometry import Array, compose, relative
from imitate.learning.support import standing_on
from imitate.record import SceneSpec, Start
from imitate.settings import Settings


def perturbed_starts(
    spec: SceneSpec, count: int, seed: np.random.SeedSequence, settings: Settings
) -> list[Start]:
    """Starts with each object moved along x and y and turned about z, none inside another.

    What stands on another goes with it.
    """
    return [
        _perturbed(spec, np.random.default_rng(child), settings.learning.shift, settings.learning.turn)
        for child in seed.spawn(count)
    ]


def _perturbed(spec: SceneSpec, rng: np.random.Generator, shift: float, turn: float) -> Start:
    below = standing_on(spec.object_poses, spec.object_sizes)
    for _ in range(1000):
        poses = spec.object_poses.copy()
        for k in np.flatnonzero(below < 0):
            poses[k, :2] += rng.uniform(-shift, shift, 2)
            half = np.deg2rad(rng.uniform(-turn, turn)) / 2
            turned = compose([0, 0, 0, 0, 0, np.sin(half), np.cos(half)], [0, 0, 0, *poses[k, 3:]])
            poses[k, 3:] = turned[3:]
        for k in np.argsort(poses[:, 2]):
            if below[k] >= 0:  # what stands on another goes with it, or it would fall
                poses[k] = compose(
                    poses[below[k]], relative(spec.object_poses[below[k]], spec.object_poses[k])
                )
        if _apart(spec, poses):
            return Start(joints=spec.home, objects=poses)
    raise ImitateError(
        f"no start with every object moved by up to {shift * 100:g} cm keeps the objects apart; they "
        "stand too close. Make learning.shift smaller."
    )


def _apart(spec: SceneSpec, poses: Array) -> bool:
    # No pair may come nearer than it was shown, unless it stays clear of each other's corners.
    radius = np.linalg.norm(spec.object_sizes[:, :2], axis=1) / 2
    need = radius[:, None] + radius[None, :]

    def gaps(p: Array) -> Array:
        return np.asarray(np.linalg.norm(p[:, None, :2] - p[None, :, :2], axis=-1))

    shown, now = gaps(spec.object_poses), gaps(poses)
    # a stack that goes as one is as it was but for rounding
    return bool(np.all((now >= np.minimum(need, shown) - 1e-9) | np.eye(len(poses), dtype=bool)))
