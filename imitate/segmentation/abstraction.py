"""Candidate abstractions ⟨O_rel, o_ref⟩ and how well each explains a segment.

Both scores of the method have one form: log P(segment, q) = Σ_{o ∈ O_rel} relevance(o) + closeness(o_ref). It
factorises over the objects, so the best O_rel is found object by object and subsets are never enumerated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import HAND, TABLE
from imitate.geometry import Array
from imitate.skill import Abstraction, Candidate


@dataclass(frozen=True)
class Evidence:
    """What speaks for each of K objects in each of many segments (…), as natural logs.

    Attributes:
        relevance: (…, K) for the object to be relevant rather than not.
        free: (…, K) for the object to be the reference of a hand that holds nothing.
        holding: (…, K) the same when something is held; never above ``free``.
        table: for the table to be the reference, when all objects are held and none is left; −inf: never.
    """

    relevance: Array
    free: Array
    holding: Array
    table: float = -np.inf


def log_prior(objects: int, going: int | None = None) -> float:
    """log p(q), uniform over all abstractions of K objects: K references, 2^(K−1) sets without it.

    Args:
        objects: K.
        going: how many of them may be in a set at all, where that is known; else all may.
    """
    others = objects - 1 if going is None else min(going, objects - 1)
    return -float(np.log(objects) + others * np.log(2))


def best_scores(evidence: Evidence) -> Array:
    """log P(segment, q) (…) under the best abstraction of all, the reference never among the relevant."""
    gain = np.maximum(evidence.relevance, 0)
    held = gain.sum(axis=-1, keepdims=True) - gain  # by each reference, without itself
    objects = np.maximum(held + evidence.holding, evidence.free).max(axis=-1)
    best: Array = np.maximum(objects, evidence.relevance.sum(axis=-1) + evidence.table)
    return best


def total_scores(evidence: Evidence) -> Array:
    """log Σ_q P(segment, q) (…) over all abstractions: those that `best_scores` takes the best of."""
    gain = np.logaddexp(evidence.relevance, 0)
    held = np.maximum(gain.sum(axis=-1, keepdims=True) - gain, 0)
    with np.errstate(divide="ignore"):
        something = held + np.log(-np.expm1(-held))  # every set of the other objects but the empty one
    objects = log_sum(np.logaddexp(something + evidence.holding, evidence.free), axis=-1)
    return np.asarray(np.logaddexp(objects, evidence.relevance.sum(axis=-1) + evidence.table))


def score_under(evidence: Evidence, abstraction: Abstraction, names: Sequence[str]) -> Array:
    """log P(segment, q) (…) under one abstraction."""
    held = [names.index(name) for name in abstraction.carried]
    relevance = np.asarray(evidence.relevance[..., held].sum(axis=-1))
    if abstraction.reference == TABLE:
        return relevance + evidence.table
    close = evidence.holding if held else evidence.free
    return np.asarray(relevance + close[..., names.index(abstraction.reference)])


def log_sum(logs: Array, axis: int) -> Array:
    """log Σ exp along an axis; −inf where all are."""
    most = logs.max(axis=axis, keepdims=True)
    most[most == -np.inf] = 0
    with np.errstate(divide="ignore"):
        total = np.log(np.exp(logs - most).sum(axis=axis))
    return np.asarray(total + most.squeeze(axis))


def candidates(evidence: Evidence, names: Sequence[str]) -> tuple[Candidate, ...]:
    """Abstractions of one segment, whose evidence this is, best first.

    Relevant sets are the best one of each reference, those that differ from it by one object, the empty set
    and the single objects: all there are for two objects, and enough to restate a problem for more. The table
    is the reference of all objects together, which leave no other.
    """
    relevance = evidence.relevance.reshape(len(names))
    found = []
    for reference, name in enumerate(names):
        for relevant in _relevant_sets(relevance, reference):
            close = (evidence.holding if relevant else evidence.free).reshape(len(names))
            score = float(sum(relevance[k] for k in relevant) + close[reference])
            found.append(Candidate(Abstraction((HAND, *(names[k] for k in relevant)), name), score))
    found.append(Candidate(Abstraction((HAND, *names), TABLE), float(relevance.sum()) + evidence.table))
    possible = [candidate for candidate in found if candidate.log_likelihood > -np.inf]
    return tuple(sorted(possible, key=lambda candidate: -candidate.log_likelihood))


def _relevant_sets(relevance: Array, reference: int) -> Iterator[tuple[int, ...]]:
    others = [k for k in range(len(relevance)) if k != reference]
    best = frozenset(k for k in others if relevance[k] > 0)
    sets = {best, frozenset[int](), *(frozenset([k]) for k in others), *(best ^ {k} for k in others)}
    for chosen in sorted(sets, key=lambda chosen: (len(chosen), sorted(chosen))):
        yield tuple(sorted(chosen))
