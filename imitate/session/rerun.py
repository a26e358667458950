"""Run a whole session again, from its seed, settings and decisions, and compare every message."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from imitate.events import Event, SessionFinished, Skipped, TrialFinished
from imitate.formats.session_log import SessionReader, Told, summarise
from imitate.formats.session_messages import SessionMessages, Stamped, topic_of
from imitate.formats.steps import TrialSteps
from imitate.learning.trials import ExecutorFactory, Trials
from imitate.session.again import event_difference, events_again, place_of, read_opening
from imitate.session.compare import Difference
from imitate.session.replay import Divergence
from imitate.session.versions import version_differences
from imitate.world.robot_files import located

_STEPS = topic_of(TrialSteps)
_SHOWN = 80
"""digits of a message that are shown."""


@dataclass(frozen=True)
class RerunReport:
    """What running a session again found.

    Attributes:
        events: how many were compared, each with its messages.
        messages: how many those were, of all topics.
        divergent: events that differ, or whose messages do.
        first_divergence: None when there is none.
        finished: whether the session had ended; else it was compared as far as it went.
        damage: what could not be read of the file.
        machine: what differs from the machine that recorded it, in words.
    """

    events: int
    messages: int
    divergent: int
    first_divergence: Divergence | None
    finished: bool
    damage: tuple[str, ...] = ()
    machine: tuple[str, ...] = ()


def rerun(
    path: Path | str,
    factory: ExecutorFactory,
    robot: str = "",
    atol: float = 0.0,
    progress: Callable[[int, int], None] | None = None,
) -> RerunReport:
    """Runs a session again and compares, event by event, until one is of another kind than recorded.

    Args:
        path: the session; a recording that it began with is not needed, its demonstration is in it.
        factory: of what runs the trials; the report is the same for any.
        robot: the TOML file beside which the robot's files are now, if not where they were.
        atol: by how much doubles may differ; 0 compares their bits, and of people's topics the bytes.
        progress: called with the trials so far and those in the file.

    Raises:
        FileError: no session, or an unreadable one.
        SceneError: the robot's files are missing or are not those recorded.
    """
    path = Path(path)
    summary = summarise(path)
    opening = read_opening(path)
    scene = located(opening.started.scene, robot)
    reader = SessionReader(path)
    comparison = _Comparison(path, scene.object_names, atol, summary.steps)
    comes: Event | None = None

    def skip(_segment: int, _formulation: int) -> bool:
        return isinstance(comes, Skipped)  # as the operator did, where it is recorded next

    with Trials(factory, scene, opening.settings, skip) as trials:
        again = events_again(opening, trials)
        for told in reader.told(steps=False):
            comes = told.event
            event = next(again, None)
            if not comparison.go_on(told, event):
                break
            if progress and isinstance(event, TrialFinished):
                progress(comparison.trials, summary.trials)
    return comparison.report(tuple(reader.damage), version_differences(opening.started.versions))


class _Comparison:
    """Folds pairs of events, as recorded and as they come again.

    Steps are compared as they are packed: equal ones are equal bytes. Where those differ they are unpacked.
    """

    def __init__(self, path: Path, objects: tuple[str, ...], atol: float, steps: bool) -> None:
        self._unpacked = enumerate(SessionReader(path).events())
        self.events = self.messages = self.divergent = self.trials = 0
        self.first: Divergence | None = None
        self.finished = False
        self._objects, self._atol, self._steps = objects, atol, steps
        self._encoder = SessionMessages(steps)
        self._beside: list[Stamped] = []

    def go_on(self, told: Told, event: Event | None) -> bool:
        """Takes a pair in; whether the two sessions still take the same course."""
        kind, same_kind = type(told.event).__name__, type(event) is type(told.event)
        if event is None or not same_kind:
            found: Difference | None = Difference("event", kind, type(event).__name__ if event else "none")
        else:
            found = self._difference(told, event, self._told(event))
        if found and self.first is None:
            values = (found.field, found.recorded, found.replayed)
            self.first = Divergence(found.step, *place_of(told.event), *values, kind, self.events)
        self.divergent += found is not None
        self.events += 1
        self.messages += 1 + len(told.beside)
        self.finished |= isinstance(told.event, SessionFinished)
        self.trials += isinstance(told.event, TrialFinished)
        return same_kind

    def _difference(self, told: Told, event: Event, again: Told) -> Difference | None:
        recorded, before, after = told.event, _steps_of(told), _steps_of(again)
        if before and (self._atol or before != after):
            recorded = next(whole for number, whole in self._unpacked if number == self.events)
        found = event_difference(recorded, event, self._objects, self._atol)
        # Steps that are missing were in a damaged chunk: the poses shown of them were too.
        lost = self._steps and isinstance(event, TrialFinished) and before is None
        if self._atol or lost:
            return found
        return found or _messages_difference(told, again)

    def _told(self, event: Event) -> Told:
        # The event as the log would tell it; what is beside it after its own message belongs to the next.
        before, self._beside = self._beside, []
        time, here = 0, before
        for topic, data, at in self._encoder.of(event):
            if topic == topic_of(type(event)):
                time, here = at, self._beside
            else:
                here.append((topic, data, at))
        return Told(event, time, tuple(before))

    def report(self, damage: tuple[str, ...], machine: tuple[str, ...]) -> RerunReport:
        """What was found."""
        return RerunReport(
            self.events, self.messages, self.divergent, self.first, self.finished, damage, machine
        )


def _steps_of(told: Told) -> bytes | None:
    return next((data for topic, data, _ in told.beside if topic == _STEPS), None)


def _messages_difference(recorded: Told, replayed: Told) -> Difference | None:
    """Where the clock or the messages for people's tools differ: equal sessions have equal bytes there."""
    if recorded.time != replayed.time:
        return Difference("log time (ns)", recorded.time, replayed.time)
    if len(recorded.beside) != len(replayed.beside):
        return Difference("messages beside it", len(recorded.beside), len(replayed.beside))
    for (topic, data, time), other in zip(recorded.beside, replayed.beside, strict=True):
        if (topic, time) != (other[0], other[2]):
            return Difference("messages beside it", f"{topic} at {time} ns", f"{other[0]} at {other[2]} ns")
        if data != other[1] and topic != _STEPS:
            return Difference(f"{topic} at {time} ns", data.hex()[:_SHOWN], other[1].hex()[:_SHOWN])
    return None
