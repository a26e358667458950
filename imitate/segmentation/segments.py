"""A demonstration cut into skills, each with the abstraction that explains it best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from imitate.demonstration import Demonstration, interpolated
from imitate.geometry import Array
from imitate.segmentation.abstraction import Evidence, best_scores, candidates
from imitate.segmentation.changepoints import Frames, Lattice, Lead, most_probable_cuts
from imitate.segmentation.cst import CstScore
from imitate.segmentation.faithful import FaithfulScore
from imitate.segmentation.rests import with_rests
from imitate.segmentation.robust import RobustScore
from imitate.segmentation.tracks import believed, tracks_of
from imitate.segmentation.visits import Visits, visited, visits, with_visits
from imitate.settings import Segmentation
from imitate.skill import Abstraction, Candidate, Segment


class Score(Protocol):
    """A score of segments over frames.

    Attributes:
        times: (T,) of the frames, seconds since the first one.
        prior: log p(q), the same for all abstractions.
    """

    times: Array
    prior: float

    def evidence(self, starts: Frames, ends: Frames) -> Evidence:
        """Evidence (E, S, K) for segments of frames start…end−1, starts (S,) and ends (E,).

        Pairs with start ≥ end may hold anything. Quickest for increasing or decreasing blocks of ends.
        """

    def between(self, start: int, end: int) -> Evidence:
        """Evidence (1, 1, K) for the one segment of frames start…end−1, as its abstraction is chosen."""

    @property
    def lead(self) -> Lead | None:
        """The bound by which the search leaves starts out; None where none is known.

        (S, O) how much more, at most, a segment from a start can score than one from the other start to the
        same end with the same abstraction, whatever these are.
        """


def segment(demonstration: Demonstration, settings: Segmentation) -> tuple[Segment, ...]:
    """The most probable skills of a demonstration, in order and without gaps."""
    whole, names = _whole(demonstration, settings), demonstration.object_names
    score = score_of(demonstration, settings)
    cuts, _ = most_probable_cuts(lattice_of(score, settings))
    cuts, chosen = _chosen(cuts, score, names, settings)
    carried = [best.abstraction.carried for best in chosen]
    rested = with_rests(cuts, carried, whole, score.times, settings)
    found = visits(whole, score.times, settings)
    cuts = with_visits(rested, carried, found, names)
    ranked = _ranked(cuts, score, names, settings, found)
    carries = {
        cut: best.abstraction for cut, best in zip(rested, chosen, strict=False) if best.abstraction.carried
    }
    ends = score.times[np.minimum(cuts, len(score.times) - 1)]
    return tuple(
        Segment(float(start), float(end), carries.get(cut, _best_free(ranking)), ranking)
        for cut, (start, end), ranking in zip(cuts, pairwise(ends), ranked, strict=False)
    )


def rankings(
    demonstration: Demonstration, settings: Segmentation, boundaries: Sequence[float]
) -> list[tuple[Candidate, ...]]:
    """How well each abstraction explains what happens between boundaries, best first.

    Args:
        boundaries: N + 1 increasing times, seconds since the first frame.

    Returns:
        N rankings.
    """
    score = score_of(demonstration, settings)
    found = visits(_whole(demonstration, settings), score.times, settings)
    cuts = frames_at(score.times, boundaries)
    return _ranked(cuts, score, demonstration.object_names, settings, found)


def frames_at(times: Array, boundaries: Sequence[float]) -> tuple[int, ...]:
    """The frames at which segments start and the last one ends; T for the end of ``times``."""
    cuts = np.searchsorted(times, boundaries).tolist()
    return (*cuts[:-1], len(times) if boundaries[-1] >= times[-1] else cuts[-1])


def score_of(demonstration: Demonstration, settings: Segmentation) -> Score:
    """The segment score of the settings' mode."""
    if settings.mode == "faithful":
        return FaithfulScore(interpolated(demonstration), settings.threshold)
    if settings.mode == "cst":
        return CstScore(interpolated(demonstration), settings.rate)
    return RobustScore(demonstration, settings)


def lattice_of(
    score: Score, settings: Segmentation, over: Callable[[Evidence], Array] = best_scores
) -> Lattice:
    """All segments there may be, each under its best abstraction or ``over`` all of them."""
    a_second = (len(score.times) - 1) / score.times[-1]
    return Lattice(
        lambda starts, ends: over(score.evidence(starts, ends)) + score.prior,
        len(score.times),
        max(settings.expected_length * a_second, 1.01),
        max(round(settings.shortest * a_second), 1),
        score.lead,
    )


def _whole(demonstration: Demonstration, settings: Segmentation) -> Demonstration:
    """Every pose known; in the robust mode those that are not believed are taken from their neighbours."""
    robust = settings.mode == "robust"
    return interpolated(
        believed(demonstration, tracks_of(demonstration, settings)) if robust else demonstration
    )


def _chosen(
    cuts: tuple[int, ...], score: Score, names: Sequence[str], settings: Segmentation
) -> tuple[tuple[int, ...], list[Candidate]]:
    """Cuts without those between two segments of one abstraction, and the best candidates between them.

    CST's segments stay as they are: two of one abstraction differ in their value functions.
    """
    while True:
        best = [ranking[0] for ranking in _ranked(cuts, score, names, settings)]
        kept = [a.abstraction != b.abstraction for a, b in pairwise(best)]
        if all(kept) or settings.mode == "cst":
            return cuts, best
        cuts = (0, *(cut for cut, keep in zip(cuts[1:-1], kept, strict=True) if keep), cuts[-1])


def _ranked(
    cuts: Sequence[int], score: Score, names: Sequence[str], settings: Segmentation, found: Visits = ()
) -> list[tuple[Candidate, ...]]:
    """Candidates of each segment, best first.

    In the robust mode a free hand goes to what it holds next, or else to what it visits (``found``), or else
    comes from what it held last, even if other objects are nearer: those references gain all that nearness
    can cost.
    """
    ranked = [candidates(score.between(a, b), names) for a, b in pairwise(cuts)]
    if settings.mode != "robust":
        return ranked
    held = [(), *(ranking[0].abstraction.carried for ranking in ranked), ()]
    seen = [tuple(names[k] for k in visited(found, a, b)) for a, b in pairwise(cuts)]
    return [
        _favour(ranking, after or there or before, settings.reference_limit) if not now else ranking
        for ranking, before, now, after, there in zip(ranked, held, held[1:], held[2:], seen, strict=False)
    ]


def _best_free(ranking: tuple[Candidate, ...]) -> Abstraction:
    return next(c.abstraction for c in ranking if not c.abstraction.carried)


def _favour(ranking: tuple[Candidate, ...], objects: Sequence[str], bonus: float) -> tuple[Candidate, ...]:
    gained = (
        replace(c, log_likelihood=c.log_likelihood + bonus)
        if c.abstraction.reference in objects and not c.abstraction.carried
        else c
        for c in ranking
    )
    return tuple(sorted(gained, key=lambda candidate: -candidate.log_likelihood))
