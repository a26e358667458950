"""The paper's score of a segment, as it states it (section 4, settled in ALGORITHMS section 2)."""

from __future__ import annotations

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array
from imitate.segmentation.abstraction import Evidence, log_prior
from imitate.segmentation.changepoints import Frames


class FaithfulScore:
    """log P = −n‖h_t − ref_t‖ + Σ log p_rel(o), n frames long, positions in metres.

    log p_rel = n(1 − σ(100 d̄)) where d̄ ≤ d_thresh, else −nσ(100 d̄); d̄ is the mean over the segment of
    ‖(h_k − h_s) − (o_k − o_s)‖, how far hand and object moved apart since the segment's start s.
    """

    lead = None  # what a segment gains by its length alone has no bound

    def __init__(self, demonstration: Demonstration, threshold: float) -> None:
        self._apart: Array = demonstration.hand[:, None, :3] - demonstration.objects[..., :3]
        self._distance: Array = np.linalg.norm(self._apart, axis=-1)
        self._threshold = threshold
        self.times = demonstration.t - demonstration.t[0]
        self.prior = log_prior(len(demonstration.object_names))
        self._end = 0
        self._drifted: Array = np.zeros(self._distance.shape)

    def evidence(self, starts: Frames, ends: Frames) -> Evidence:
        """Evidence (E, S, K) for segments of frames start…end−1, starts (S,) and ends (E,)."""
        n = np.maximum(ends[:, None] - starts, 1)[..., None]
        mean = self._drift(starts, ends) / n
        sigma = 1 / (1 + np.exp(-100 * mean))
        relevance = np.where(mean <= self._threshold, n * (1 - sigma), -n * sigma)
        close = -n * self._distance[ends - 1][:, None]
        return Evidence(relevance, close, close)

    def between(self, start: int, end: int) -> Evidence:
        """Evidence (1, 1, K) for the one segment of frames start…end−1."""
        return self.evidence(np.array([start]), np.array([end]))

    def _drift(self, starts: Frames, ends: Frames) -> Array:
        """(E, S, K) Σ ‖apart_k − apart_start‖ over the frames k of each segment."""
        if len(starts) == 1:
            apart = self._apart[starts[0] : ends.max()]
            total: Array = np.cumsum(np.linalg.norm(apart - apart[0], axis=-1), axis=0)
            return np.asarray(total[ends - starts - 1][:, None])
        at = np.minimum(starts, len(self.times) - 1)
        return np.stack([self._up_to(int(end))[at] for end in ends])

    def _up_to(self, end: int) -> Array:
        """(T, K) the sums from each start, from those of the last end that was asked for."""
        while self._end < end:
            self._end += 1
            self._drifted[: self._end] += self._apart_from(self._end)
        while self._end > end:
            self._drifted[: self._end] -= self._apart_from(self._end)
            self._end -= 1
        return self._drifted

    def _apart_from(self, end: int) -> Array:
        apart: Array = self._apart[:end] - self._apart[end - 1]
        return np.asarray(np.linalg.norm(apart, axis=-1))
