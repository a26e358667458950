"""The most probable cuts of a sequence, exactly, under any score of a segment (Fearnhead & Liu 2007)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from imitate.geometry import Array


def most_probable_cuts(
    scores: Iterable[Array], frames: int, expected_length: float, shortest: int = 1
) -> tuple[tuple[int, ...], float]:
    """The maximum a posteriori cuts when segment lengths are geometric (ALGORITHMS section 2).

    Maximises Σ_segments score + K log p + (T − K) log(1 − p) with p = 1 / ``expected_length``, as a shortest
    path over all pairs of start and end: O(T²), one vectorised step per end.

    Args:
        scores: for each end t = 1…T in turn, (t,) the log score of frames j…t−1 for each start j = 0…t−1,
            under the best model of a segment, its prior included.
        frames: T.
        expected_length: mean length of a segment, frames, > 1.
        shortest: frames that a segment has at least; a sequence shorter than that is one segment.

    Returns:
        (0, …, T), where each segment starts and the last one ends, in frames; and the maximum.
    """
    switch, stay = np.log(1 / expected_length), np.log1p(-1 / expected_length)
    shortest = min(shortest, frames)
    lengths = np.arange(frames, 0, -1)
    best = np.full(frames + 1, -np.inf)
    best[0] = 0
    previous = np.zeros(frames + 1, int)
    for end, score in enumerate(scores, start=1):
        starts = end - shortest + 1
        if starts > 0:
            total = best[:starts] + score[:starts] + (lengths[-end:][:starts] - 1) * stay
            previous[end] = np.argmax(total)
            best[end] = total[previous[end]] + switch
    cuts = [frames]
    while cuts[-1] > 0:
        cuts.append(int(previous[cuts[-1]]))
    return tuple(reversed(cuts)), float(best[-1])
