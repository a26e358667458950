"""The gripper's force, from the parameters of a policy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imitate.geometry import Array
from imitate.policy.dmp import Response, response, rollout
from imitate.settings import PolicySettings
from imitate.skill import Policy


def force_response(ticks: int, kernels: int, holds: bool, settings: PolicySettings) -> Response:
    """What the gripper's force answers to its weights; one that ``holds`` has its last weight for a goal."""
    shape = response(ticks, kernels, settings.gripper_decay, settings.gripper_stiffness)
    if not holds:
        return shape
    goal = np.zeros((ticks, kernels))
    goal[:, -1] = shape.goal
    return replace(shape, kernels=shape.kernels + goal, noise=shape.noise + goal)


def forces(policy: Policy, ticks: int, limit: float, settings: PolicySettings) -> Array:
    """The gripper's command (ticks,) in N of a policy with a gripper action, at most ``limit``; 0 is open.

    Args:
        policy: the parameters.
        ticks: control ticks of its wait and its movement together.
        limit: N.
        settings: of the movement.
    """
    weights = policy.gripper_weights
    shape = force_response(ticks, len(weights), policy.holds, settings)
    zero = np.zeros(1)
    noise = policy.gripper_noise[:, None]
    force = rollout(shape, zero, zero, weights[:, None], noise)[:, 0]
    return np.where(force > settings.open_below, np.minimum(force, limit), 0.0)
