"""Policy learning by weighting exploration with the returns (PoWER; Kober & Peters 2011)."""

from __future__ import annotations

import numpy as np

from imitate.geometry import Array


def returns(costs: Array, scale: float) -> Array:
    """Rewards (K,) in 0…1 of costs (K,): exp(−S / scale). Unlike PI²'s, they do not depend on each other."""
    return np.asarray(np.exp(-np.asarray(costs, float) / scale))


def power_update(noise: Array, rewards: Array) -> Array:
    """δθ = Σ_k R_k ε_k / Σ_k R_k for noise that is constant over a rollout; 0 where nothing is rewarded.

    Args:
        noise: ε (K, ...) of the best K rollouts ever, relative to the mean that is updated.
        rewards: R (K,), not negative.

    Returns:
        δθ, shaped like one ε.
    """
    total = rewards.sum()
    if total <= 0:
        return np.zeros(noise.shape[1:])
    return np.asarray(np.tensordot(rewards / total, noise, axes=1))
