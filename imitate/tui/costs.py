"""What a formulation's trials cost, as a curve to draw. Knows no Textual."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

from imitate.session.progress import Attempt

Terms = Literal["total", "end", "acceleration", "gripper"]
TERMS: tuple[Terms, ...] = ("total", "end", "acceleration", "gripper")
"""a trial's cost, and what it is the sum of."""


@dataclass(frozen=True)
class Curve:
    """Exploring trials as (number, cost), apart by success; updates as (number of trials before, cost).

    ``terms``: of all of them, each part of the cost.
    """

    failed: tuple[tuple[int, float], ...]
    succeeded: tuple[tuple[int, float], ...]
    updates: tuple[tuple[int, float], ...]
    terms: tuple[tuple[Terms, tuple[tuple[int, float], ...]], ...] = ()

    @classmethod
    def of(cls, attempt: Attempt | None, terms: Collection[Terms] = TERMS[:1]) -> Curve:
        """The curve of a formulation, of these terms; empty without one."""
        if attempt is None:
            return cls((), (), ())
        explored = [k for k, trial in enumerate(attempt.trials) if trial.purpose == "explore"]
        trials = [(n, attempt.trials[k]) for n, k in enumerate(explored, start=1)]
        total = trials if "total" in terms else []
        parts: tuple[tuple[Terms, str], ...] = (
            ("end", "terminal"), ("acceleration", "acceleration"), ("gripper", "gripper"),
        )  # fmt: skip
        return cls(
            tuple((n, trial.cost.total) for n, trial in total if not trial.success),
            tuple((n, trial.cost.total) for n, trial in total if trial.success),
            tuple((bisect_left(explored, u.after), u.cost) for u in attempt.updates if total),
            tuple(
                (term, tuple((n, getattr(trial.cost, field)) for n, trial in trials))
                for term, field in parts
                if term in terms and trials
            ),
        )
