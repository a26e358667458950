"""Option: initiation set, policy, termination; and P(β = 1 | π) with its interval."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from imitate.geometry import Array
from imitate.learning.problem import Problem
from imitate.skill import InitiationSet, Policy

_Z = 1.959963984540054  # 97.5 % quantile of the normal distribution


@dataclass(frozen=True)
class Option:
    """⟨I, π, β⟩: from where it is likely to succeed, a policy, and the problem's judgement at the end.

    Attributes:
        problem: its `misses_of` is β.
        policy: π.
        initiation: I; None in sessions of before it was kept.
        ends: (m, K + 1, 7) world poses of the hand and the K objects where β held, over the trials by which P
            was estimated.
    """

    problem: Problem
    policy: Policy
    initiation: InitiationSet | None = None
    ends: Array = field(default_factory=lambda: np.zeros((0, 0, 7)))


@dataclass(frozen=True)
class Success:
    """Successes out of trials, with Wilson's 95 % interval."""

    successes: int
    trials: int

    @property
    def rate(self) -> float:
        """The point estimate of P."""
        return self.successes / self.trials if self.trials else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval (low, high) within 0…1."""
        n, p = self.trials, self.rate
        if not n:
            return 0.0, 1.0
        middle = (p + _Z**2 / (2 * n)) / (1 + _Z**2 / n)
        half = _Z / (1 + _Z**2 / n) * np.sqrt(p * (1 - p) / n + _Z**2 / (4 * n * n))
        low = 0.0 if self.successes == 0 else float(middle - half)
        return low, 1.0 if self.successes == n else float(middle + half)  # the ends are exact
