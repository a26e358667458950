"""The baseline that the paper compares with: Konidaris' CST, which cuts where a value function changes.

Constructing skill trees (Konidaris, Kuindersma, Grupen & Barto 2012): a segment is one skill if the return to
its end is linear in functions of the hand's position in one object's frame. Formulas: ALGORITHMS section 2.
"""

from __future__ import annotations

import numpy as np
from scipy.special import gammaln

from imitate.demonstration import Demonstration
from imitate.geometry import Array, relative, resample
from imitate.segmentation.abstraction import Evidence
from imitate.segmentation.changepoints import Frames

ORDER = 3
"""of the independent Fourier basis: 1 + 3·3 functions of a position."""
WEIGHT_VARIANCE = 1e4
"""δ: weights ~ N(0, σ²δI)."""
NOISE_SHAPE, NOISE_SCALE = 1e-4, 50.0
"""v ≈ 0 and u of σ² ~ inverse gamma(v/2, u/2), whose mode is 25 frames²."""
REWARD = -1.0
"""of each frame, undiscounted (γ = 1)."""


class CstScore:
    """log P(segment, ⟨{hand}, o_ref⟩): marginal likelihood of a regression, on frames at a fixed rate.

    The return R_i of frame i, up to the segment's end, is regressed on the basis functions Φ of the hand's
    position in the frame of o_ref. Sums over a segment are differences of sums up to its two ends.
    """

    lead = None  # a bound on what one start can gain on another is not known

    def __init__(self, demonstration: Demonstration, rate: float) -> None:
        """On frames at ``rate`` Hz of a demonstration with every pose known."""
        d, t = demonstration, demonstration.t - demonstration.t[0]
        self.times: Array = np.linspace(0, t[-1], max(2, 1 + round(t[-1] * rate)))
        self.prior = -float(np.log(len(d.object_names)))
        hand = resample(t, d.hand, self.times)
        objects = [resample(t, d.pose_of(name), self.times) for name in d.object_names]
        features = np.stack([fourier(relative(pose, hand)[:, :3]) for pose in objects])
        frame = np.arange(len(self.times))[:, None]
        self._outer = _sums(features[..., None] * features[..., None, :])
        self._plain, self._timed = _sums(features), _sums(frame * features)

    def evidence(self, starts: Frames, ends: Frames) -> Evidence:
        """Evidence (E, S, K) for segments of frames start…end−1, starts (S,) and ends (E,)."""
        free = np.stack([self._at_one_end(np.minimum(starts, end - 1), int(end)) for end in ends])
        never = np.broadcast_to(-np.inf, free.shape)
        return Evidence(relevance=never, free=free, holding=never)

    def between(self, start: int, end: int) -> Evidence:
        """Evidence (1, 1, K) for the one segment of frames start…end−1."""
        return self.evidence(np.array([start]), np.array([end]))

    def _at_one_end(self, starts: Frames, end: int) -> Array:
        """(S, K) for segments start…end−1; the return of frame i is (end − i) rewards."""
        a = self._outer[:, end, None] - self._outer[:, starts]
        b = REWARD * (
            end * (self._plain[:, end, None] - self._plain[:, starts])
            - (self._timed[:, end, None] - self._timed[:, starts])
        )
        n: Array = (end - starts).astype(float)
        squares = REWARD**2 * n * (n + 1) * (2 * n + 1) / 6
        return log_likelihood(a, b, squares, n).T


def log_likelihood(a: Array, b: Array, squares: Array, n: Array) -> Array:
    """log P of returns regressed on m basis functions, weights and noise integrated out.

    P = π^{−n/2} δ^{−m/2} |A+D|^{−1/2} u^{v/2} / (y+u)^{(n+v)/2} Γ((n+v)/2) / Γ(v/2), D = I/δ,
    y = ΣR² − bᵀ(A+D)^{−1}b.

    Args:
        a: (..., m, m) ΣΦΦᵀ.
        b: (..., m) ΣRΦ.
        squares: (...) ΣR².
        n: (...) frames.
    """
    m, u, v = b.shape[-1], NOISE_SCALE, NOISE_SHAPE
    precision = a + np.eye(m) / WEIGHT_VARIANCE
    y = squares - np.sum(b * np.linalg.solve(precision, b[..., None])[..., 0], axis=-1)
    logs: Array = (
        -n / 2 * np.log(np.pi)
        - m / 2 * np.log(WEIGHT_VARIANCE)
        - np.linalg.slogdet(precision)[1] / 2
        + v / 2 * np.log(u)
        - (n + v) / 2 * np.log(np.maximum(y, 0) + u)
        + gammaln((n + v) / 2)
        - gammaln(v / 2)
    )
    return logs


def fourier(x: Array) -> Array:
    """(T, 1 + 3·ORDER) independent Fourier basis of positions (T, 3), least to most scaled to 0…1."""
    low, span = x.min(axis=0), np.ptp(x, axis=0)
    scaled = (x - low) / np.where(span > 0, span, 1)
    waves = [np.cos(np.pi * k * scaled) for k in range(1, ORDER + 1)]
    return np.concatenate([np.ones((len(x), 1)), *waves], axis=1)


def _sums(values: Array) -> Array:
    """(K, T + 1, …) sums of values (K, T, …) over the first 0…T frames."""
    return np.concatenate([np.zeros_like(values[:, :1]), np.cumsum(values, axis=1)], axis=1)
