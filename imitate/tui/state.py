"""What the screens show: one session, from the file that was opened to its result. Knows no Textual."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from imitate.demonstration import Demonstration
from imitate.events import Event, FormulationStarted, OptionLearned, Reformulated, TrialFinished
from imitate.session.progress import Attempt, Progress
from imitate.settings import Settings
from imitate.skill import Decision, Segment
from imitate.tui.again import Checking, Library, Starts, Trying
from imitate.tui.album import Album
from imitate.tui.pace import Pace
from imitate.tui.series import Series
from imitate.tui.sighting import Sighting

if TYPE_CHECKING:
    from imitate.formats.kind import Kind
    from imitate.segmentation import Doubt

Step = Literal["load", "observe", "review", "learn", "reproduce", "replay"]
Interval = tuple[float, float]


@dataclass
class State:
    """The session as it stands; the application changes it, Review its segments, the other screens read it.

    Attributes:
        source: the file that was opened.
        kind: what it is.
        found: segments as the search found them.
        segments: those that result from the operator's ``decisions``.
        changes: from when to when, with 90 % probability, the motion changes at each boundary, seconds since
            the first frame; empty until it is known for these ``segments``.
        doubts: where ``segments`` are far less likely than ``found``; None until that is known.
        weighed: the segments for which ``changes`` and ``doubts`` are sought.
        along: what each frame says for each object to move along with the hand; None until that is known.
        album: the recording's pictures.
        observed: share of a recording's frames that were tracked, 0 to 1.
        sighting: those frames, once there are any.
        unseen: why a recording could not be observed; empty while it can.
        notes: what ought to be known of how the demonstration was read or observed.
        running: whether a child process is learning.
        stopping: whether it was asked to stop.
        pausing: whether it was asked to wait after the present trial.
        skipping: the formulation that is to be given up: its segment and its index there; None for none.
        ended: whether learning ended, by itself or by the operator.
        log: the session's file.
        starts: from where Reproduce runs the task next.
        trying, checking, library: what Reproduce and Replay have done so far.
        pace: how fast trials come.
    """

    settings: Settings = field(default_factory=Settings)
    seed: int = 0
    workers: int = 1
    source: Path | None = None
    kind: Kind = "demonstration"
    demonstration: Demonstration | None = None
    found: tuple[Segment, ...] = ()
    segments: tuple[Segment, ...] = ()
    decisions: tuple[Decision, ...] = ()
    changes: tuple[Interval, ...] = ()
    doubts: tuple[Doubt, ...] | None = None
    weighed: tuple[Segment, ...] = ()
    along: Series | None = None
    album: Album = field(default_factory=Album)
    observed: float = 0.0
    sighting: Sighting | None = None
    unseen: str = ""
    notes: tuple[str, ...] = ()
    running: bool = False
    stopping: bool = False
    pausing: bool = False
    skipping: tuple[int, int] | None = None
    ended: bool = False
    log: Path | None = None
    starts: Starts = field(default_factory=Starts)
    trying: Trying = field(default_factory=Trying)
    checking: Checking = field(default_factory=Checking)
    library: Library = field(default_factory=Library)
    pace: Pace = field(default_factory=Pace)
    progress: Progress = field(default_factory=Progress)
    _before: Progress | None = None

    @property
    def steps(self) -> tuple[Step, ...]:
        """The road of this session."""
        watched: tuple[Step, ...] = ("observe",) if self.kind == "recording" else ()
        return ("load", *watched, "review", "learn", "reproduce", "replay")

    @property
    def editable(self) -> bool:
        """Whether the segments can be changed: not a recorded session's, nor while learning."""
        return self.kind != "session" and not self.running

    def reachable(self, step: Step) -> bool:
        """Whether there is something to see at a step."""
        match step:
            case "load":
                return True
            case "observe":
                return self.kind == "recording" and (self.demonstration is None or self.sighting is not None)
            case "review":
                return self.demonstration is not None
            case "learn":
                return self.running or bool(self.progress.skills)
            case "reproduce" | "replay":
                return self.ended

    def done(self, step: Step) -> bool:
        """Whether what a step is for has been done."""
        match step:
            case "load":
                return self.source is not None
            case "observe":
                return self.demonstration is not None
            case "review":
                return self.running or bool(self.progress.skills)
            case "learn":
                return self.whole
            case "reproduce":
                return self.progress.reproduced is not None or self.trying.result is not None
            case "replay":
                return self.checking.report is not None

    def open(self, source: Path, kind: Kind) -> None:
        """Begin anew with another file."""
        self._leave_the_log()
        self.album.stopping = True
        fresh = State(self.settings, self.seed, self.workers, source, kind, pace=self.pace)
        self.__dict__.update(fresh.__dict__)

    def wear(self, left: str, right: str) -> None:
        """The fingers' colours were picked: the recording is to be observed with them; all begins anew."""
        worn = self.settings.perception.model_copy(update={"left_finger": left, "right_finger": right})
        self.settings = self.settings.model_copy(update={"perception": worn})
        if self.source is not None:
            self.open(self.source, self.kind)

    def leave(self) -> None:
        """What is being opened is not wanted any more."""
        if self.kind == "recording" and self.demonstration is None and not self.unseen:
            self.unseen = "Left before it was done. Observe it again (r): it begins from the first picture."

    def sight(self, later: Sighting) -> None:
        """Frames were tracked; those of an observation that was left are of nobody's interest."""
        before = self.sighting
        if later.begin == (len(before) if before else 0):
            self.sighting = before.then(later) if before else later
            self.observed = self.sighting.share

    def show(
        self, demonstration: Demonstration, segments: tuple[Segment, ...], notes: tuple[str, ...] = ()
    ) -> None:
        """A demonstration was read or observed, and cut."""
        self.notes = notes
        self.demonstration, self.found, self.segments = demonstration, segments, segments
        self.decisions, self.changes, self.doubts, self.along = (), (), None, None

    def decide(self, decision: Decision, segments: tuple[Segment, ...]) -> None:
        """The operator overruled something; ``segments`` result."""
        self.decisions = (*self.decisions, decision)
        self.segments, self.changes, self.doubts = segments, (), None

    @property
    def undoable(self) -> int:
        """How many decisions can still be undone."""
        return sum(-1 if decision.kind == "undo" else 1 for decision in self.decisions)

    @property
    def redoable(self) -> int:
        """How many undone decisions can be done again: nothing else was decided after them."""
        undone = 0
        for decision in self.decisions:
            undone = max(0, undone + {"undo": 1, "redo": -1}.get(decision.kind, -undone))
        return undone

    def begin(self, log: Path | None) -> None:
        """Learning starts."""
        self._leave_the_log()
        self.progress, self.log, self._before = Progress(), log, None
        self.pace.begin()
        self.running, self.stopping, self.pausing, self.ended = True, False, False, False
        self.skipping = None

    def go_on(self, log: Path) -> None:
        """A session that was stopped is gone on with; all its events come again."""
        before = self.progress
        self.begin(log)
        self._before = before

    def _leave_the_log(self) -> None:
        # What is done with the session before ends; what it still says is of nobody's interest.
        for work in (self.trying, self.checking, self.library):
            work.stopping = True
        self.trying, self.checking, self.library = Trying(), Checking(), Library()

    @property
    def skippable(self) -> bool:
        """Whether a formulation is being improved, so that it can be given up for the next one."""
        present = self.progress.present
        improves = present is not None and not (present.converged or present.accepted or present.given_up)
        return self.running and not self.stopping and self.skipping is None and improves

    def skip(self) -> None:
        """The present formulation is not wanted any more."""
        present = self.progress.present
        if self.skippable and present is not None:
            self.skipping = (present.formulation.segment, present.formulation.index)

    def fold(self, event: Event) -> None:
        """Something happened in the session."""
        self.progress.fold(event)
        if isinstance(event, FormulationStarted | OptionLearned | Reformulated):
            self.skipping = None
        if self.running and isinstance(event, TrialFinished):
            self.pace.tick()

    def end(self) -> None:
        """The engine has nothing more to say; a session that did not even start has no result."""
        self.running, self.stopping, self.pausing, self.skipping = False, False, False, None
        if self.progress.started is None and self._before:  # it could not be gone on with
            self.progress = self._before
        self.ended = self.progress.started is not None

    def show_recorded(self, log: Path) -> None:
        """All events of a recorded session are folded: take demonstration and segments from them."""
        started = self.progress.started
        self.demonstration = started.demonstration if started else None
        self.found = self.progress.segmented.segments if self.progress.segmented else ()
        self.segments = tuple(skill.segment for skill in self.progress.skills)
        self.decisions = tuple(self.progress.decisions)
        self.log = log
        self.end()

    @property
    def resumable(self) -> bool:
        """Whether the session was stopped or cut, and can be gone on with."""
        return self.ended and self.log is not None and self.progress.finished is None

    @property
    def whole(self) -> bool:
        """Whether every skill was learned, so that there is a task to run."""
        return self.ended and bool(self.progress.skills) and all(s.accepted for s in self.progress.skills)

    @property
    def attempts(self) -> list[Attempt]:
        """Every formulation so far, by skill and in order."""
        return [attempt for skill in self.progress.skills for attempt in skill.attempts]


def moved(
    demonstration: Demonstration,
    segments: tuple[Segment, ...],
    boundary: int,
    frames: int = 0,
    seconds: float = 0.0,
) -> Decision | None:
    """The decision that moves the end of segment ``boundary``, always to the time of a frame.

    Args:
        frames: by how many frames, or
        seconds: by how much time (to the nearest frame, at least one).

    Returns:
        None when the boundary would leave a segment without frames, or there is none.
    """
    if not 0 <= boundary < len(segments) - 1:
        return None
    t = demonstration.t - demonstration.t[0]
    end = segments[boundary].end
    present = int(np.argmin(np.abs(t - end)))
    target = present + frames
    if seconds:
        step = 1 if seconds > 0 else -1
        nearest = int(np.argmin(np.abs(t - (t[present] + seconds))))
        target = nearest if (nearest - present) * step >= 1 else present + step
    if not 0 < target < len(t) - 1:
        return None
    time = float(t[target])
    inside = segments[boundary].start < time < segments[boundary + 1].end
    return Decision("move", boundary, time) if inside and time != end else None
