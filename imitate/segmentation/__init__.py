"""A demonstration to segments (the paper, section 4).

Symbols::

    j, t        a segment is frames j…t−1, n = t − j frames long
    q           an abstraction ⟨O_rel, o_ref⟩; the hand is always relevant, o_ref never
    k           mean length of a segment, frames
    d̄           how far hand and object move apart over a segment, metres
    ℓ           what one frame says for an object to move with the hand, nats
"""

from imitate.segmentation.doubts import Doubt, Hasty, doubts, hasty
from imitate.segmentation.overrides import apply_decisions, split_time
from imitate.segmentation.posteriors import Posterior, Posteriors, changes, posteriors
from imitate.segmentation.segments import rankings, segment

__all__ = [
    "Doubt",
    "Hasty",
    "Posterior",
    "Posteriors",
    "apply_decisions",
    "changes",
    "doubts",
    "hasty",
    "posteriors",
    "rankings",
    "segment",
    "split_time",
]
