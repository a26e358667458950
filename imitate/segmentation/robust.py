"""A score of a segment that survives noise, rests and many objects (ALGORITHMS section 2, robust mode).

Each frame weighs two explanations of an object's displacement over a short window: it moved with the hand, or
it stood still. Frames in which the hand rests speak for neither.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array, resample
from imitate.segmentation.abstraction import Evidence
from imitate.settings import Segmentation


class RobustScore:
    """log P = Σ_{o ∈ O_rel} (Σ_k ℓ_k(o) − penalty) − d / ℓ_ref, on frames resampled at a fixed rate.

    ℓ = [‖Δo‖² − ‖Δo − Δh‖²] / (2 s² w), clipped; s² = 4σ² + (still noise)², w the window in frames. d is the
    distance from the hand to the reference at the end if something is held, else the smaller of those at
    start and end.
    """

    def __init__(self, demonstration: Demonstration, settings: Segmentation) -> None:
        t = demonstration.t - demonstration.t[0]
        self.times: Array = np.append(np.arange(0, t[-1], 1 / settings.rate), t[-1])
        hand, objects = demonstration.hand[:, :3], demonstration.objects[..., :3]
        variance = 2 * noise(t, hand[:, None]) ** 2 + 2 * noise(t, objects) ** 2 + settings.slack**2
        h = resample(t, demonstration.hand, self.times)[:, None, :3]
        o = resample(t, demonstration.objects, self.times)[..., :3]
        moved_h, moved_o = _displacement(h, settings.window), _displacement(o, settings.window)
        gain = np.sum(moved_o**2, axis=-1) - np.sum((moved_o - moved_h) ** 2, axis=-1)
        step = np.clip(gain / (2 * variance * settings.window), -settings.clip, settings.clip)
        self._sum = np.concatenate([np.zeros((1, step.shape[1])), np.cumsum(step, axis=0)])
        self._distance = np.linalg.norm(h - o, axis=-1)
        self._settings = settings

    def ends(self) -> Iterator[Evidence]:
        """Evidence for every start j = 0…t−1, for each end t = 1…T in turn."""
        for end in range(1, len(self.times) + 1):
            yield self._evidence(slice(0, end), end)

    def between(self, start: int, end: int) -> Evidence:
        """Evidence for the one segment of frames start…end−1."""
        return self._evidence(slice(start, start + 1), end)

    def _evidence(self, starts: slice, end: int) -> Evidence:
        relevance = self._sum[end] - self._sum[starts] - self._settings.object_penalty
        at_end = self._distance[end - 1]
        nearest = np.minimum(self._distance[starts], at_end)
        holding = np.broadcast_to(-at_end / self._settings.reference_length, nearest.shape)
        return Evidence(relevance, -nearest / self._settings.reference_length, holding)


def noise(t: Array, positions: Array) -> Array:
    """Standard deviation (K,) of the noise per axis of positions (T, K, 3), metres.

    From the median absolute deviation of each frame from the straight line between its neighbours, which
    constant velocity and irregular times leave at zero.
    """
    if len(t) < 3:
        return np.zeros(positions.shape[1])
    u = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None, None]
    off = positions[1:-1] - (1 - u) * positions[:-2] - u * positions[2:]
    spread = np.sqrt(1 + (1 - u) ** 2 + u**2)
    deviation: Array = 1.4826 * np.median(np.abs(off) / spread, axis=(0, 2))
    return deviation


def _displacement(positions: Array, window: int) -> Array:
    """How far positions (T, …, 3) move over ``window`` frames centred on each one; less at the ends."""
    frames = np.arange(len(positions))
    first = np.maximum(frames - window // 2, 0)
    last = np.minimum(first + window, len(positions) - 1)
    return np.asarray(positions[last] - positions[np.maximum(last - window, 0)])
