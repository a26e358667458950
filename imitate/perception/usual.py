"""How well a body's pixels usually agree with it, so that worse is noticed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WORSE = 0.1
"""log-likelihood a pixel by which a fit may always fall short of the usual."""
DEVIATIONS = 3.5
"""times the usual deviation by which it may."""
MEMORY = 20
"""frames that the usual is a mean over."""


@dataclass
class Usual:
    """Mean and variance of the scores of the last frames, and the best share of pixels that agreed."""

    mean: float = -np.inf
    variance: float = (WORSE / 2) ** 2
    agreement: float = 0.0
    frames: int = 0

    def is_worse(self, score: float) -> bool:
        """Whether a score is below what noise explains."""
        return score < self.mean - self._margin

    def relative(self, agreement: float) -> float:
        """0…1 a share of agreeing pixels as a share of the best so far; 1 before the first frame."""
        return min(1.0, agreement / self.agreement) if self.agreement else 1.0

    def learn(self, score: float, agreement: float) -> None:
        """Takes a frame in; one that is much worse counts as one that is just not worse."""
        self.agreement = max(self.agreement, agreement)
        if not self.frames:
            self.mean, self.frames = score, 1
            return
        self.frames = min(self.frames + 1, MEMORY)
        off = float(np.clip(score - self.mean, -self._margin, self._margin))
        self.mean += off / self.frames
        self.variance += (off**2 - self.variance) / self.frames

    @property
    def _margin(self) -> float:
        return max(WORSE, DEVIATIONS * float(np.sqrt(self.variance)))
