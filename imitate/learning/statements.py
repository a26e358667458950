"""In which order a skill's problem is stated (the paper's Algorithm 1)."""

from __future__ import annotations

from imitate.settings import Learning
from imitate.skill import Abstraction, Action, Segment

Statement = tuple[Abstraction, tuple[Action, ...]]


def statements(segment: Segment, settings: Learning) -> list[Statement]:
    """Formulations of a segment in the order of Algorithm 1: M, ranked, each without and with the gripper.

    The abstraction chosen comes first; the others are those less likely by at most α_model (log). Those that
    drop a body which is shown to be carried come last (``keep_carried``; the paper makes no difference).
    """
    ranked = [segment.abstraction]
    if segment.alternatives:
        best = max(candidate.log_likelihood for candidate in segment.alternatives)
        ranked += [
            candidate.abstraction
            for candidate in segment.alternatives
            if best - candidate.log_likelihood <= settings.model_threshold
            and candidate.abstraction != segment.abstraction
        ]
    if settings.keep_carried:
        ranked.sort(key=lambda abstraction: bool(dropped(segment, abstraction)))
    actions: tuple[tuple[Action, ...], ...] = (("pose",), ("pose", "gripper"))
    return [(abstraction, action) for abstraction in ranked for action in actions]


def dropped(segment: Segment, abstraction: Abstraction) -> tuple[str, ...]:
    """What the segment shows carried and ``abstraction`` does not carry."""
    return tuple(body for body in segment.abstraction.carried if body not in abstraction.carried)


def dropped_in_words(segment: Segment, abstraction: Abstraction) -> str:
    """What is not carried any more under ``abstraction``; empty where all that was shown still is."""
    names = dropped(segment, abstraction)
    if names and not abstraction.carried:
        return "nothing is carried any more"
    return f"{' and '.join(names)} {'are' if len(names) > 1 else 'is'} not carried any more" if names else ""
