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
from imitate.perception.shapes import Places

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


def anneal(
    particles: Array,
    score: Score,
    layers: int,
    generator: np.random.Generator,
    enough: Array | float = 0.0,
) -> Estimate:
    """The most likely change, from particles (N, D) drawn from what is expected.

    Args:
        particles: the first layer's.
        score: (N, D) → (N,) log-likelihoods.
        layers: how many times they are weighted, at most.
        generator: of every draw.
        enough: (D,) standard deviations at which the search ends early.
    """
    for layer in range(layers):
        weights = _weights(np.asarray(score(particles), float))
        mean = weights @ particles
        apart = particles - mean
        covariance = (apart * weights[:, None]).T @ apart
        deviation = np.sqrt(np.diag(covariance))
        if layer == layers - 1 or np.all(deviation <= enough):
            break
        drawn = _systematic(weights, generator)
        noise = generator.standard_normal(particles.shape) @ _root(covariance).T
        particles = particles[drawn] + SPREAD * noise
    return Estimate(mean, deviation, float(score(mean[None])[0]))


def around(guesses: Array, deviations: Array, count: int, generator: np.random.Generator) -> Array:
    """(count, D) particles around guesses (G, D), with deviations (D,); the guesses themselves first."""
    centres = guesses[np.arange(count) % len(guesses)]
    drawn = centres + deviations * generator.standard_normal(centres.shape)
    drawn[: len(guesses)] = guesses
    return np.asarray(drawn)


def expected(particles: Array, guesses: Array, deviations: Array) -> Array:
    """(N,) log-density of changes, but for a constant, around the nearest of the guesses (G, D).

    Deviations (D,) of 0 leave their dimension out.
    """
    free = deviations > 0
    apart = (particles[:, None, free] - guesses[:, free]) / deviations[free]
    return np.asarray(-np.sum(apart**2, axis=2).min(axis=1) / 2)


def guessed(base: Array, changes: Array) -> Places:
    """As `moved`, as places."""
    turned = Rotation.from_rotvec(changes[:, 3:6]).as_matrix() @ Rotation.from_quat(base[3:]).as_matrix()
    return Places(turned, base[:3] + changes[:, :3])


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
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0)))


def _systematic(weights: Array, generator: np.random.Generator) -> NDArray[np.intp]:
    count = len(weights)
    marks = (generator.random() + np.arange(count)) / count
    return np.minimum(np.searchsorted(np.cumsum(weights), marks), count - 1)
