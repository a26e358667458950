"""Policies tried around a mean policy, and the mean that results (the paper, section 5.2).

Constant noise over a rollout with its total cost is PI^BB, and with a covariance that follows what was cheap
PI²-CMA; noise per kernel with the cost to go is PI²; rewards of the best trials ever, PoWER.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imitate.events import TrialFinished
from imitate.geometry import Array, normalised, read_only
from imitate.learning.problem import immediate_costs
from imitate.policy.dmp import response
from imitate.policy.pi2 import constant_update, covariance_update, per_kernel_update, probabilities
from imitate.policy.power import power_update, returns
from imitate.settings import Settings
from imitate.skill import Policy, policy_ticks


@dataclass(frozen=True)
class Spread:
    """Covariances of the noise of pose weights (D, n, n), a channel each, and of gripper weights (m, m)."""

    pose: Array
    gripper: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", read_only(self.pose))
        object.__setattr__(self, "gripper", read_only(self.gripper))


def first_spread(mean: Policy, settings: Settings) -> Spread | None:
    """The covariances to start from; None where the exploration does not adapt any."""
    if settings.learning.exploration != "covariance":
        return None
    variance, s = _deviation(mean, settings) ** 2, settings.learning
    squeeze = s.gripper_noise**2 * _alike(len(mean.gripper_weights), s.gripper_smoothness)
    return Spread(variance[:, None, None] * np.eye(len(mean.pose_weights)), squeeze)


def sample(
    mean: Policy, rng: np.random.Generator, factor: float, settings: Settings, spread: Spread | None = None
) -> Policy:
    """A policy near ``mean``; ``factor`` (0…1) scales its noise, unless ``spread`` says how much there is."""
    s = settings.learning
    pose = rng.standard_normal(mean.pose_weights.shape)
    gripper = rng.standard_normal(mean.gripper_weights.shape)
    if spread is None:
        pose = factor * _deviation(mean, settings) * pose
        alike = np.linalg.cholesky(_alike(len(gripper), s.gripper_smoothness))
        gripper = factor * s.gripper_noise * (alike @ gripper)
    else:
        pose = np.einsum("dij,jd->id", np.linalg.cholesky(spread.pose), pose)
        gripper = np.linalg.cholesky(spread.gripper) @ gripper
    if s.goal_noise or s.goal_turn_noise:
        mean = _aimed(mean, rng, factor * np.repeat([s.goal_noise, s.goal_turn_noise], [3, 4]))
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
        costs: of each trial; with noise per kernel the trials' own terms count for the weights.
    """
    s = settings.learning
    pose, gripper, goal = _noise(mean, trials)
    if s.exploration == "per-kernel":
        to_go = np.stack([cost_to_go(trial, settings) for trial in trials], axis=1)
        wait, _ = policy_ticks(mean, settings.world.control_rate)
        change = _per_kernel(pose, to_go[wait:], settings.policy.phase_decay, settings)
        squeeze = _per_kernel(gripper[..., None], to_go, settings.policy.gripper_decay, settings)[:, 0]
        aim = np.tensordot(probabilities(to_go[0], s.eliteness), goal, axes=1)
    elif s.exploration == "power":
        rewards = returns(np.array(costs), s.reward_cost)
        change, squeeze, aim = (power_update(noise, rewards) for noise in (pose, gripper, goal))
    else:
        change, squeeze, aim = (
            constant_update(noise, np.array(costs), s.eliteness) for noise in (pose, gripper, goal)
        )
    weights = mean.pose_weights + change
    moved = replace(mean, pose_weights=weights, gripper_weights=mean.gripper_weights + squeeze)
    return replace(moved, goal=normalised(mean.goal + aim)) if goal.any() else moved


def adapted(
    spread: Spread | None,
    mean: Policy,
    trials: Sequence[TrialFinished],
    costs: Sequence[float],
    settings: Settings,
) -> Spread | None:
    """The covariances after an update of ``mean`` (as it was before) from the same trials."""
    if spread is None:
        return None
    s = settings.learning
    pose, gripper, _ = _noise(mean, trials)
    by = np.array(costs), s.eliteness, s.covariance_rate
    return Spread(
        covariance_update(
            spread.pose, pose.swapaxes(1, 2), *by, least=s.least_noise * _deviation(mean, settings)
        ),
        covariance_update(spread.gripper, gripper, *by, least=np.array(s.least_noise * s.gripper_noise)),
    )


def _aimed(mean: Policy, rng: np.random.Generator, deviation: Array) -> Policy:
    return replace(mean, goal=normalised(mean.goal + deviation * rng.standard_normal(7)))


def _alike(kernels: int, smoothness: float) -> Array:
    # (n, n) correlation of the noise of kernels so far from each other.
    if not smoothness:
        return np.eye(kernels)
    at = np.arange(kernels)
    return np.asarray(np.exp(-np.abs(at[:, None] - at) / smoothness))


def _deviation(mean: Policy, settings: Settings) -> Array:
    # (D,) of the pose weights of each channel.
    return np.asarray(settings.learning.pose_noise * np.abs(mean.pose_weights).mean(axis=0))


def _noise(mean: Policy, trials: Sequence[TrialFinished]) -> tuple[Array, Array, Array]:
    # (K, n, D), (K, m) and (K, 7): pose weights, gripper weights and goals of K trials relative to the mean.
    policies = [trial.policies[-1] for trial in trials]
    pose = np.array([p.pose_weights - mean.pose_weights for p in policies])
    gripper = np.array([p.gripper_weights - mean.gripper_weights for p in policies])
    pose += [_or_zero(p.pose_noise, pose[0]) for p in policies]
    gripper += [_or_zero(p.gripper_noise, gripper[0]) for p in policies]
    return pose, gripper, np.array([p.goal - mean.goal for p in policies])


def cost_to_go(trial: TrialFinished, settings: Settings) -> Array:
    """S_i = φ_N + Σ_{j≥i} q_j (C,) over wait and movement; one cut short cost nothing more after its end."""
    if trial.record is None:
        raise ValueError("a trial without its record has no costs in time")
    acceleration, switches = immediate_costs(trial.record, settings.learning)
    ticks = sum(policy_ticks(trial.policies[-1], settings.world.control_rate))
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
