"""An annealed particle filter over a pose (Deutscher & Reid 2005), for bodies of known shape.

Particles are small changes to a base pose: a shift in metres, a turn as a rotation vector in radians, and
whatever else is unknown of the body. In each layer they are weighted by a power of the likelihood that
keeps a set share of them effective, drawn again, and spread by their own covariance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, quaternion_multiply

Score = Callable[[Array], NDArray[np.float32]]

EFFECTIVE = 0.25
"""share of the particles that stay effective after weighting."""
SPREAD = 0.6
"""of the weighted particles' standard deviation, the noise that they are spread by between layers."""


@dataclass(frozen=True)
class Estimate:
    """Weighted mean (D,) and standard deviation (D,) of the particles, and the mean's log-likelihood."""

    mean: Array
    deviation: Array
    score: float


def anneal(particles: Array, score: Score, layers: int, generator: np.random.Generator) -> Estimate:
    """The most likely change, from particles (N, D) drawn from what is expected.

    Args:
        particles: the first layer's.
        score: (N, D) → (N,) log-likelihoods.
        layers: how many times they are weighted.
        generator: of every draw.
    """
    for layer in range(layers):
        weights = _weights(np.asarray(score(particles), float))
        mean = weights @ particles
        apart = particles - mean
        covariance = (apart * weights[:, None]).T @ apart
        if layer < layers - 1:
            root = _root(covariance)
            drawn = _systematic(weights, generator)
            noise = generator.standard_normal(particles.shape) @ root.T
            particles = particles[drawn] + SPREAD * noise
    final = float(score(mean[None])[0])
    return Estimate(mean, np.sqrt(np.diag(covariance)), final)


def moved(base: Array, changes: Array) -> Array:
    """(N, 7) ``base`` (7,) shifted by changes[:, :3] and turned by the rotation vectors changes[:, 3:6]."""
    turns = Rotation.from_rotvec(changes[:, 3:6]).as_quat()
    return np.concatenate([base[:3] + changes[:, :3], quaternion_multiply(turns, base[3:])], axis=1)


def _weights(scores: Array) -> Array:
    """Normalised powers of the likelihoods, the power as high as 1 as long as enough stay effective."""
    least = EFFECTIVE * len(scores)
    relative = scores - scores.max()
    low, high = 0.0, 1.0
    if _effective(relative) >= least:
        low = 1.0
    for _ in range(0 if low else 25):
        middle = (low + high) / 2
        low, high = (middle, high) if _effective(middle * relative) >= least else (low, middle)
    weights = np.exp(low * relative)
    return np.asarray(weights / weights.sum())


def _effective(logs: Array) -> float:
    weights = np.exp(logs)
    return float(weights.sum() ** 2 / (weights**2).sum())


def _root(covariance: Array) -> Array:
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 1e-12)))


def _systematic(weights: Array, generator: np.random.Generator) -> NDArray[np.intp]:
    count = len(weights)
    marks = (generator.random() + np.arange(count)) / count
    return np.minimum(np.searchsorted(np.cumsum(weights), marks), count - 1)
