"""The paper's score of a segment, as it states it (section 4, settled in ALGORITHMS section 2)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.geometry import Array
from imitate.segmentation.abstraction import Evidence


class FaithfulScore:
    """log P = −n‖h_t − ref_t‖ + Σ log p_rel(o), n frames long, positions in metres.

    log p_rel = n(1 − σ(100 d̄)) where d̄ ≤ d_thresh, else −nσ(100 d̄); d̄ is the mean over the segment of
    ‖(h_k − h_s) − (o_k − o_s)‖, how far hand and object moved apart since the segment's start s.
    """

    def __init__(self, demonstration: Demonstration, threshold: float) -> None:
        self._apart: Array = demonstration.hand[:, None, :3] - demonstration.objects[..., :3]
        self._distance = np.linalg.norm(self._apart, axis=-1)
        self._threshold = threshold
        self.times = demonstration.t - demonstration.t[0]

    def ends(self) -> Iterator[Evidence]:
        """Evidence for every start j = 0…t−1, for each end t = 1…T in turn."""
        frames, objects, _ = self._apart.shape
        drifted = np.zeros((frames, objects))
        for end in range(1, frames + 1):
            drifted[:end] += np.linalg.norm(self._apart[end - 1] - self._apart[:end], axis=-1)
            yield self._evidence(np.arange(end), end, drifted[:end])

    def between(self, start: int, end: int) -> Evidence:
        """Evidence for the one segment of frames start…end−1."""
        drifted = np.linalg.norm(self._apart[start:end] - self._apart[start], axis=-1).sum(axis=0)
        return self._evidence(np.array([start]), end, drifted[None])

    def _evidence(self, starts: NDArray[np.int_], end: int, drifted: Array) -> Evidence:
        n = (end - starts)[:, None]
        mean = drifted / n
        sigma = 1 / (1 + np.exp(-100 * mean))
        relevance = np.where(mean <= self._threshold, n * (1 - sigma), -n * sigma)
        close = -n * self._distance[end - 1]
        return Evidence(relevance, close, close)
