"""A score of a segment that survives noise, rests and many objects (ALGORITHMS section 2, robust mode).

Each frame weighs two explanations of an object's displacement over a short window: it moved with the hand, or
it stood still. Frames in which the hand rests speak for neither.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array
from imitate.segmentation.abstraction import Evidence, log_prior
from imitate.segmentation.changepoints import Frames
from imitate.segmentation.motion import going_along
from imitate.segmentation.tracks import tracks_of
from imitate.settings import Segmentation


class RobustScore:
    """log P = Σ_{o ∈ O_rel} (Σ_k ℓ_k(o) − penalty) + c(d), on frames resampled at a fixed rate.

    ℓ_k is what frame k says for o to go with the hand (`going_along`). d is the distance from the hand to the
    reference at the end if something is held, else the smaller of those at start and end.
    Bounds: P without c is additive in time but for the penalty; free ≥ holding > −C.
    c(d) = −C (1 − exp(−d / (ℓ_ref C))) lies in (−C, 0]; the table, the last resort, has −C.
    """

    def __init__(self, demonstration: Demonstration, settings: Segmentation) -> None:
        d, t = demonstration, demonstration.t - demonstration.t[0]
        self._settings = settings
        self.times: Array = np.linspace(0, t[-1], max(2, 1 + round(t[-1] * settings.rate)))
        hand, *bodies = tracks_of(d, settings)
        step = np.column_stack([going_along(t, hand, body, self.times, settings) for body in bodies])
        self._sum = np.concatenate([np.zeros((1, step.shape[1])), np.cumsum(step, axis=0)])
        places = [
            np.column_stack([np.interp(self.times, t[b.known], b.poses[b.known, axis]) for axis in range(3)])
            for b in (hand, *bodies)
        ]
        self._where: Array = np.stack(places[1:], axis=1)
        self._close = self._closeness(self._where - places[0][:, None])
        # an object that goes along in no segment is in no set: else 500 that lie about would forbid any cut
        rises = (self._sum - np.minimum.accumulate(self._sum, axis=0)).max(axis=0)
        going = int(np.count_nonzero(rises > settings.object_penalty))
        self.prior = log_prior(len(d.object_names), going)

    @property
    def said(self) -> Array:
        """(T, K) nats that each frame says for each object to go with the hand."""
        return np.diff(self._sum, axis=0)

    def evidence(self, starts: Frames, ends: Frames) -> Evidence:
        """Evidence (E, S, K) for segments of frames start…end−1, starts (S,) and ends (E,)."""
        relevance = self._sum[ends][:, None] - self._sum[starts] - self._settings.object_penalty
        at_end = self._close[ends - 1][:, None]
        free = np.maximum(self._close[starts.clip(max=len(self.times) - 1)], at_end)
        return Evidence(relevance, free, np.broadcast_to(at_end, free.shape), -self._settings.reference_limit)

    def between(self, start: int, end: int) -> Evidence:
        """Evidence (1, 1, K) for the one segment of frames start…end−1.

        Here d is from the origin of what is held to the reference, as the hand may hold it far from that.
        """
        found = self.evidence(np.array([start]), np.array([end]))
        held = np.flatnonzero(found.relevance > 0)
        if not len(held):
            return found
        apart = self._where[end - 1] - self._where[end - 1, held, None]
        return replace(found, holding=self._closeness(apart).max(axis=0)[None, None])

    def lead(self, starts: Frames, others: Frames) -> Array:
        """(S, O) how much more, at most, a segment from a start can score than one from the other start.

        To any one end and with the same abstraction: what is held differs by the evidence between the two
        starts, each object by its own if that is positive, and a free hand's reference by its closeness.
        """
        last = len(self.times) - 1
        more, nearer = np.zeros((2, len(starts), len(others)))
        for total, close in zip(self._sum.T, self._close.T, strict=True):
            more += np.maximum(total[others] - total[starts][:, None], 0)
            nearer = np.maximum(nearer, close[starts.clip(max=last)][:, None] - close[others.clip(max=last)])
        return np.maximum(more, nearer)

    def _closeness(self, apart: Array) -> Array:
        """c(d) for displacements (..., 3)."""
        far = self._settings.reference_limit
        distance = np.linalg.norm(apart, axis=-1)
        return np.asarray(far * np.expm1(-distance / (self._settings.reference_length * far)))
