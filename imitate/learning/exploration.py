"""Policies tried around a mean policy, and the mean that results (the paper, section 5.2).

Constant noise over a rollout with its total cost is PI^BB; noise per kernel with the cost to go is PI².
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imitate.events import TrialFinished
from imitate.geometry import Array
from imitate.learning.problem import immediate_costs
from imitate.policy.dmp import response
from imitate.policy.pi2 import constant_update, per_kernel_update
from imitate.settings import Settings
from imitate.skill import Policy


def sample(mean: Policy, rng: np.random.Generator, factor: float, settings: Settings) -> Policy:
    """A policy near ``mean``; ``factor`` (0…1) scales the noise of its pose and gripper weights."""
    s = settings.learning
    spread = s.pose_noise * np.abs(mean.pose_weights).mean(axis=0)
    pose = factor * spread * rng.standard_normal(mean.pose_weights.shape)
    gripper = factor * s.gripper_noise * rng.standard_normal(mean.gripper_weights.shape)
    if s.exploration == "per-kernel":
        return replace(mean, pose_noise=pose, gripper_noise=gripper)
    return replace(
        mean, pose_weights=mean.pose_weights + pose, gripper_weights=mean.gripper_weights + gripper
    )


def improved(
    mean: Policy, trials: Sequence[TrialFinished], costs: Sequence[float], settings: Settings
) -> Policy:
    """The mean policy after an update from trials whose last policy was on trial.

    Earlier trials may be among them: their noise is taken relative to the present mean.

    Args:
        costs: of each trial, for constant noise; with noise per kernel the trials' own terms count.
    """
    policies = [trial.policies[-1] for trial in trials]
    pose = np.array([p.pose_weights - mean.pose_weights for p in policies])
    gripper = np.array([p.gripper_weights - mean.gripper_weights for p in policies])
    if settings.learning.exploration == "per-kernel":
        pose += [_or_zero(p.pose_noise, pose[0]) for p in policies]
        gripper += [_or_zero(p.gripper_noise, gripper[0]) for p in policies]
        to_go = np.stack([cost_to_go(trial, settings) for trial in trials], axis=1)
        change = _per_kernel(pose, to_go, settings.policy.phase_decay, settings)
        squeeze = _per_kernel(gripper[..., None], to_go, settings.policy.gripper_decay, settings)[:, 0]
    else:
        change = constant_update(pose, np.array(costs), settings.learning.eliteness)
        squeeze = constant_update(gripper, np.array(costs), settings.learning.eliteness)
    return replace(
        mean, pose_weights=mean.pose_weights + change, gripper_weights=mean.gripper_weights + squeeze
    )


def cost_to_go(trial: TrialFinished, settings: Settings) -> Array:
    """S_i = φ_N + Σ_{j≥i} q_j (C,) over the movement; one cut short cost nothing more after its end."""
    if trial.record is None:
        raise ValueError("a trial without its record has no costs in time")
    acceleration, switches = immediate_costs(trial.record, settings.learning)
    ticks = round(trial.policies[-1].duration * settings.world.control_rate)
    immediate = np.zeros(max(ticks, len(acceleration)))
    immediate[: len(acceleration)] = acceleration + switches
    return np.asarray(trial.cost.terminal + np.cumsum(immediate[::-1])[::-1])[:ticks]


def _per_kernel(noise: Array, to_go: Array, decay: float, settings: Settings) -> Array:
    if not noise.shape[1]:
        return np.zeros(noise.shape[1:])
    shape = response(len(to_go), noise.shape[1], decay, settings.policy.stiffness)
    return per_kernel_update(noise, to_go, shape.activations, settings.learning.eliteness)


def _or_zero(noise: Array, like: Array) -> Array:
    return noise if len(noise) else np.zeros_like(like)
