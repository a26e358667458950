"""A score of a segment that survives noise, rests and many objects (ALGORITHMS section 2, robust mode).

Each frame weighs two explanations of an object's displacement over a short window: it moved with the hand, or
it stood still. Frames in which the hand rests speak for neither.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array, resample
from imitate.segmentation.abstraction import Evidence
from imitate.segmentation.motion import believable, going_along
from imitate.segmentation.nudges import Nudge
from imitate.settings import Segmentation


class RobustScore:
    """log P = Σ_{o ∈ O_rel} (Σ_k ℓ_k(o) − penalty) + c(d), on frames resampled at a fixed rate.

    ℓ_k is what frame k says for o to go with the hand (`going_along`). d is the distance from the hand to the
    reference at the end if something is held, else the smaller of those at start and end.
    c(d) = −C (1 − exp(−d / (ℓ_ref C))) lies in (−C, 0]; the table, the last resort, has −C.
    """

    def __init__(
        self, demonstration: Demonstration, settings: Segmentation, passing: Sequence[Nudge] = ()
    ) -> None:
        """A score in which nothing speaks for an object to be carried in the ``passing`` nudges."""
        d, t = demonstration, demonstration.t - demonstration.t[0]
        self._settings = settings
        self.times: Array = np.linspace(0, t[-1], max(2, 1 + round(t[-1] * settings.rate)))
        by_hand = believable(t, d.hand, settings.slack)
        hand = resample(t[by_hand], d.hand[by_hand], self.times)
        said, distance = [], []
        for name in d.object_names:
            track = d.pose_of(name)
            known = believable(t, track, settings.slack)
            both = known & by_hand
            said.append(going_along(t[both], d.hand[both], track[both], self.times, settings))
            seen = resample(t[known], track[known], self.times)
            distance.append(np.linalg.norm(hand[:, :3] - seen[:, :3], axis=1))
        step = np.column_stack(said)
        for nudge in passing:
            step[nudge.start : nudge.end, nudge.body] = np.minimum(
                step[nudge.start : nudge.end, nudge.body], 0
            )
        self._sum = np.concatenate([np.zeros((1, step.shape[1])), np.cumsum(step, axis=0)])
        far = settings.reference_limit
        self._close: Array = -far * -np.expm1(-np.column_stack(distance) / (settings.reference_length * far))

    def ends(self) -> Iterator[Evidence]:
        """Evidence for every start j = 0…t−1, for each end t = 1…T in turn."""
        for end in range(1, len(self.times) + 1):
            yield self._evidence(slice(0, end), end)

    def between(self, start: int, end: int) -> Evidence:
        """Evidence for the one segment of frames start…end−1."""
        return self._evidence(slice(start, start + 1), end)

    def _evidence(self, starts: slice, end: int) -> Evidence:
        relevance = self._sum[end] - self._sum[starts] - self._settings.object_penalty
        at_end = self._close[end - 1]
        free = np.maximum(self._close[starts], at_end)
        return Evidence(relevance, free, np.broadcast_to(at_end, free.shape), -self._settings.reference_limit)
