"""A session's course from what was shown to its end: everything in it follows from its first event."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from imitate import events
from imitate.demonstration import Demonstration, interpolated
from imitate.events import Event, SessionStarted
from imitate.learning.reformulate import Search, learn_options
from imitate.learning.reproduce import reproduce
from imitate.learning.statements import dropped_in_words
from imitate.learning.trials import Trials
from imitate.segmentation import apply_decisions, segment
from imitate.settings import Settings
from imitate.skill import Decision, Segment
from imitate.world.scene import shown_start

_REPRODUCTION = 0xA11  # spawn key of the starts of the reproduction, beyond any segment's index


def segmented(
    demonstration: Demonstration, decisions: Sequence[Decision], settings: Settings
) -> list[events.Segmented | events.Decided]:
    """The segments as found, and after each of the operator's decisions.

    Raises:
        ImitateError: a decision cannot be made.
    """
    found = segment(demonstration, settings.segmentation)
    told: list[events.Segmented | events.Decided] = [events.Segmented(settings.segmentation.mode, found)]
    for count, decision in enumerate(decisions, start=1):
        result = apply_decisions(found, decisions[:count], demonstration, settings.segmentation)
        told.append(events.Decided(decision, result))
    return told


def course(started: SessionStarted, segments: tuple[Segment, ...], trials: Trials) -> Iterator[Event]:
    """Learns every skill and runs the whole task: all events after the segments are settled."""
    demonstration = interpolated(started.demonstration)
    shown = shown_start(started.scene)
    search = yield from learn_options(demonstration, segments, trials, shown, started.seed)
    if search.given_up:
        yield events.SessionFinished(False, f"{search.given_up} {_next_command(started)}", search.best)
        return
    yield from _reproduction(started, demonstration, segments, search, trials)


def _reproduction(
    started: SessionStarted,
    demonstration: Demonstration,
    segments: tuple[Segment, ...],
    search: Search,
    trials: Trials,
) -> Iterator[Event]:
    seeds = np.random.SeedSequence(started.seed, spawn_key=(_REPRODUCTION,))
    count = trials.settings.learning.reproduction_starts
    reproduced, failures = False, []
    for event in reproduce(demonstration, segments, search.options, trials, seeds, count):
        if isinstance(event, events.TrialFinished) and event.failure:
            failures.append(event.failure)
        if isinstance(event, events.Reproduced):
            reproduced = event.reproduced
        yield event
    advice = ""
    if not reproduced:
        advice = (
            f"every skill was learned, but together they fail from {len(failures)} of {count} starts: "
            f"{max(failures, key=failures.count)}. {_dropped(segments, search)}{_next_command(started)}"
        )
    yield events.SessionFinished(reproduced, advice)


def _dropped(segments: tuple[Segment, ...], search: Search) -> str:
    # Which skill was only learned without what it is shown to carry.
    for number, (shown, option) in enumerate(zip(segments, search.options, strict=True), start=1):
        abstraction = option.problem.formulation.abstraction
        if words := dropped_in_words(shown, abstraction):
            return f"Skill {number} was learned only as {abstraction}: {words}. "
    return ""


def _next_command(started: SessionStarted) -> str:
    return (
        f"Try another seed: imitate learn {started.source} --seed {started.seed + 1}; "
        f"or look at the segments and correct them: imitate tui {started.source}"
    )
