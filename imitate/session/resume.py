"""Go on where a session stopped: what is recorded is taken from its log, what is missing is simulated.

A session follows from its first event, so it is run again from there, and each trial that the log holds is
answered with its record instead of physics. What comes of it must be what is recorded, event by event. The
log is written anew beside the old one, and takes its place as soon as it holds all that the old one does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from imitate.errors import FileError
from imitate.events import Event, Skipped, TrialFinished
from imitate.formats.growing import held
from imitate.formats.session_log import SessionReader, summarise
from imitate.formats.session_pictures import kept_pictures
from imitate.formats.session_writer import SessionWriter
from imitate.learning.trials import ExecutorFactory, Skip, Task, Trials, nothing_is_skipped
from imitate.record import SceneSpec, TrialRecord
from imitate.session.again import (
    Opening,
    event_difference,
    events_again,
    read_opening,
)
from imitate.session.compare import first_difference
from imitate.session.versions import version_differences
from imitate.settings import Settings
from imitate.world.robot_files import located
from imitate.world.trial import Outcome


@dataclass(frozen=True)
class Resumption:
    """What is to be gone on with.

    Attributes:
        path: the session; what is written takes its place.
        factory: of what runs the trials.
        robot: the TOML file beside which the robot's files are now, if not where they were.
        rrd: where the viewer's file is written anew; None writes none.
    """

    path: Path
    factory: ExecutorFactory
    robot: str = ""
    rrd: Path | None = None


def resume(
    resumption: Resumption,
    should_stop: Callable[[], bool] = lambda: False,
    skip: Skip = nothing_is_skipped,
) -> Iterator[Event]:
    """All events of the session, those recorded first; none where it has ended and its file is whole.

    Args:
        resumption: what to do.
        should_stop: asked after each event; true ends the session there, its log valid.
        skip: asked after each batch of trials whether its formulation is given up; not of those recorded.

    Raises:
        FileError: no session, one that another process is writing, or one that does not come out again as it
            is recorded; the file is as it was.
        SceneError: the robot's files are missing or are not those recorded.
    """
    path = resumption.path
    summary = summarise(path)
    if summary.complete:
        return
    with ExitStack() as stack:
        stack.enter_context(held(path))
        opening = read_opening(path)
        scene = located(opening.started.scene, resumption.robot)
        recorded = _Recorded(path, opening)
        trials = stack.enter_context(
            _Remembering(resumption.factory, scene, opening.settings, recorded.or_asked(skip), recorded)
        )
        successor = stack.enter_context(_Successor(path, recorded, summary.steps))
        listeners = [successor.write, *_views(resumption, stack)]
        for event in events_again(opening, trials):
            recorded.check(event)
            for listen in listeners:
                listen(event)
            yield event
            if should_stop():
                return
        recorded.check_end()


def _views(resumption: Resumption, stack: ExitStack) -> list[Callable[[Event], None]]:
    if resumption.rrd is None:
        return []
    from imitate.session.viewer import Viewer  # rerun takes 0.4 s to import

    viewer = Viewer(resumption.rrd, force=True, pictures=kept_pictures(resumption.path))
    stack.callback(viewer.close)
    return [viewer.write]


class _Recorded:
    """The events that the log holds; ``next`` is the one to come, None after the last."""

    def __init__(self, path: Path, opening: Opening) -> None:
        self._path, self._opening = path, opening
        self._reader = SessionReader(path)
        self._events = self._reader.events()
        self.next: Event | None = next(self._events, None)

    def check(self, again: Event) -> None:
        """Passes the next event recorded, if there is one; it is the same, but for steps that are lost.

        Raises:
            FileError: it is another.
        """
        before = self.next
        if before is None:
            return
        if found := event_difference(before, again, self._opening.started.scene.object_names):
            what = f"{type(before).__name__}.{found.field}"
            self._refuse(f"{what} is {found.recorded!r} and would now be {found.replayed!r}")
        self.next = next(self._events, None)

    def or_asked(self, skip: Skip) -> Skip:
        """What is recorded of the operator's skipping, and after that what is asked."""

        def either(segment: int, formulation: int) -> bool:
            return skip(segment, formulation) if self.next is None else isinstance(self.next, Skipped)

        return either

    def check_end(self) -> None:
        """Raises FileError when more is recorded than comes out."""
        if self.next is not None:
            self._refuse(f"{type(self.next).__name__} would now not be there")

    def _refuse(self, what: str) -> None:
        words = [*self._reader.damage, *version_differences(self._opening.started.versions)]
        raise FileError(
            self._path,
            f"cannot be gone on with, because it does not come out again as it is recorded: {what}"
            + (f" ({'; '.join(words)})" if words else ""),
            f"It is as it was. `imitate replay {self._path} --session` says more.",
        )


class _Remembering(Trials):
    """Trials that take from the log what is recorded and simulate what is not."""

    def __init__(
        self, factory: ExecutorFactory, spec: SceneSpec, settings: Settings, skip: Skip, recorded: _Recorded
    ) -> None:
        super().__init__(factory, spec, settings, skip)
        self._recorded = recorded

    def run(self, tasks: Sequence[Task]) -> Iterator[Outcome]:
        """The outcomes, in the order of the tasks."""
        done = 0
        while done < len(tasks) and (outcome := _recalled(self._recorded.next, tasks[done])):
            done += 1
            yield outcome
        yield from super().run(tasks[done:])


def _recalled(event: Event | None, task: Task) -> Outcome | None:
    """What a recorded trial gave, if it is that of the task and has its steps."""
    if not isinstance(event, TrialFinished) or event.record is None:
        return None
    if first_difference((event.record.start, event.policies), (task.start, task.policies)):
        return None
    unreachable = next((miss.words for miss in event.misses if miss.term == "reach"), "")
    sight = next((miss.words for miss in event.misses if miss.term == "sight"), "")
    return Outcome(event.record, unreachable, sight if _stopped_blind(event.record) else "", event.seen)


def _stopped_blind(record: TrialRecord) -> bool:
    # A skill whose reference was never seen holds the last command once; any other holds still for a while.
    return len(record.commands) - record.option_starts[-1] // record.control_every == 1


class _Successor:
    """The log written anew: under a name of its own until it holds what the old one does."""

    def __init__(self, path: Path, recorded: _Recorded, steps: bool) -> None:
        self._path, self._recorded = path, recorded
        self._part = path.with_name(f".{path.name}.part")
        self._log = SessionWriter(self._part, force=True, steps=steps, pictures=kept_pictures(path))
        self._follows = False

    def write(self, event: Event) -> None:
        """Adds one event.

        Raises:
            FileError: it cannot be written.
        """
        try:
            self._log.write(event)
            if self._recorded.next is None and not self._follows:
                self._log.take_place_of(self._path)
                self._follows = True
        except FileError as error:
            if self._follows:
                raise
            raise FileError(self._path, f"is as it was, and cannot be gone on with ({error})") from error

    def __enter__(self) -> _Successor:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self._log.close()
        finally:
            self._part.unlink(missing_ok=True)  # it is there only if it does not follow
