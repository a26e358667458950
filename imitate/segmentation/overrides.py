"""The operator's decisions, applied to the segments as found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imitate.demonstration import HAND, TABLE, Demonstration
from imitate.errors import UnknownNameError, UsageError
from imitate.segmentation.abstraction import best_scores
from imitate.segmentation.segments import frames_at, rankings, score_of
from imitate.settings import Segmentation
from imitate.skill import Abstraction, Decision, Segment

SHORTEST = 0.1
"""s; what a segment lasts at least. A skill cannot be learned from less."""

Segments = tuple[Segment, ...]


def apply_decisions(
    found: Segments, decisions: Sequence[Decision], demonstration: Demonstration, settings: Segmentation
) -> Segments:
    """Segments after all ``decisions`` in order.

    An "undo" takes back the last one that still holds, a "redo" the last undo that nothing was decided after;
    a "reset" leads back to ``found``, and can be undone like any other.

    A segment whose boundary changed is ranked anew, and keeps its abstraction when its boundary was moved;
    split and merged segments take their best one.

    Raises:
        UsageError: a decision that cannot be applied, in words; those before it are not at fault.
    """
    history, undone = [found], []
    for number, decision in enumerate(decisions, start=1):
        try:
            if decision.kind == "undo":
                if len(history) == 1:
                    raise UsageError("there is nothing to undo.")
                undone.append(history.pop())
            elif decision.kind == "redo":
                if not undone:
                    raise UsageError("there is nothing to redo.")
                history.append(undone.pop())
            else:
                undone.clear()
                now = history[-1]
                reset = decision.kind == "reset"
                history.append(found if reset else _applied(now, decision, demonstration, settings))
        except UsageError as error:
            raise UsageError(f"decision {number} ({decision.kind}): {error}") from None
    return history[-1]


def split_time(demonstration: Demonstration, segment: Segment, settings: Segmentation) -> float:
    """Where a segment is best split: each part under its best abstraction; seconds since the first frame.

    Raises:
        UsageError: it is too short for two.
    """
    score = score_of(demonstration, settings)
    first, last = frames_at(score.times, (segment.start, segment.end))
    inside = np.flatnonzero(
        (score.times >= segment.start + SHORTEST) & (score.times <= segment.end - SHORTEST)
    )
    if not len(inside):
        raise UsageError(
            f"{segment.start:.2f} to {segment.end:.2f} s is too short to be split; each part must last "
            f"{SHORTEST:g} s at least."
        )
    before = best_scores(score.evidence(np.array([first]), inside))[:, 0]
    after = best_scores(score.evidence(inside, np.array([last])))[0]
    return float(score.times[inside[np.argmax(before + after)]])


def _applied(
    segments: Segments, decision: Decision, demonstration: Demonstration, settings: Segmentation
) -> Segments:
    k, kind = decision.segment, decision.kind
    needed = k + 1 if kind in ("move", "merge") else k
    if k < 0 or needed >= len(segments):
        what = f"are no segments {k} and {k + 1}" if needed > k else f"is no segment {k}"
        raise UsageError(f"there {what}; segments are numbered 0 to {len(segments) - 1}.")
    first, last = segments[k], segments[needed]
    if kind == "relabel":
        changed = [_relabelled(first, decision.abstraction, demonstration)]
    elif kind == "merge":
        changed = [replace(first, end=last.end)]
    else:
        _check_time(decision.time, first.start, last.end)
        changed = [replace(first, end=decision.time), replace(last, start=decision.time)]
    result = (*segments[:k], *changed, *segments[needed + 1 :])
    if kind == "relabel":
        return result
    ranked = rankings(demonstration, settings, [*(s.start for s in result), result[-1].end])
    for i in range(k, k + len(changed)):
        best = result[i].abstraction if kind == "move" else ranked[i][0].abstraction
        anew = replace(result[i], abstraction=best, alternatives=ranked[i], human=True)
        result = (*result[:i], anew, *result[i + 1 :])
    return result


def _relabelled(s: Segment, wanted: Abstraction | None, demonstration: Demonstration) -> Segment:
    if wanted is None:
        raise UsageError("no abstraction is given.")
    names = demonstration.object_names
    for name, valid in [*((name, names) for name in wanted.carried), (wanted.reference, (*names, TABLE))]:
        if name not in valid:
            raise UnknownNameError("object", name, valid)
    if wanted.relevant[:1] != (HAND,):
        raise UsageError(f"{wanted}: the hand is always relevant, and named first.")
    if len(set(wanted.relevant)) < len(wanted.relevant):
        raise UsageError(f"{wanted}: an object is named twice.")
    if wanted.reference in wanted.relevant:
        raise UsageError(f"{wanted}: the reference cannot be one of the relevant objects.")
    ordered = Abstraction((HAND, *(name for name in names if name in wanted.carried)), wanted.reference)
    return replace(s, abstraction=ordered, human=True)


def _check_time(time: float, start: float, end: float) -> None:
    if not start + SHORTEST <= time <= end - SHORTEST:
        raise UsageError(
            f"{time:g} s is outside of {start + SHORTEST:.2f} to {end - SHORTEST:.2f} s, which leaves both "
            f"segments {SHORTEST:g} s at least."
        )
