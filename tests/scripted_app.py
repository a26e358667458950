"""The application on an engine that only plays a script: no file formats, no physics, no clock."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path

import numpy as np
import scripted
from textual.pilot import Pilot

from imitate.demonstration import Demonstration
from imitate.errors import FileError, UsageError
from imitate.events import Event, Reproduced
from imitate.learning.option import Success
from imitate.segmentation import Doubt
from imitate.session.replay import ReplayReport
from imitate.settings import Settings
from imitate.skill import Decision, Segment
from imitate.tui.again import Check, Runs
from imitate.tui.album import shot_of
from imitate.tui.app import ImitateApp
from imitate.tui.engine import Engine
from imitate.tui.files import Preview
from imitate.tui.film import Film
from imitate.tui.pace import Pace
from imitate.tui.photo import photo_of_terminal
from imitate.tui.series import Series
from imitate.tui.sighting import Sighting
from imitate.tui.state import Interval
from imitate.tui.teaching import Resumed, Task
from imitate.tui.words import demonstration_facts

TRACKED, LOST = 150, (60, 75)
"""frames that are tracked at first, and those in which the hand is lost."""
SAME = ReplayReport(38, 79_320, 0, 0, None)


@dataclass
class Script:
    """What the engine plays, and what it was asked.

    Attributes:
        story: the events that learning yields.
        hold: whether learning waits at the story's end until it is stopped, as a long session does; observing
            waits likewise, unless it is ``watched``.
        ending: raised at the end of the story.
        unseen: raised when a recording is first observed; where it is ``late``, after all frames.
        noted: what observing says of the recording.
        stopped: whether learning ended because it was asked to.
        tasks: what learning was asked for.
        watches: what observing was asked for.
        rest: the events of going on with the session, which does not hold.
        report: what a replay finds; it holds as learning does.
        resumed, runs, checks, viewed: what going on, reproducing, replaying and Rerun were asked for.
    """

    story: Iterable[Event] = ()
    hold: bool = False
    watched: bool = False
    stopped: bool = False
    ending: Exception | None = None
    unseen: Exception | None = None
    late: bool = False
    noted: Iterable[str] = ()
    rest: Iterable[Event] = ()
    report: ReplayReport = SAME
    tasks: list[Task] = field(default_factory=list)
    resumed: list[Resumed] = field(default_factory=list)
    runs: list[Runs] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    viewed: list[Path] = field(default_factory=list)
    to_skip: Callable[[], tuple[int, int] | None] = lambda: None
    watches: list[Task] = field(default_factory=list)

    def learn(
        self,
        task: Task,
        should_stop: Callable[[], bool],
        should_wait: Callable[[], bool],
        to_skip: Callable[[], tuple[int, int] | None],
    ) -> Iterator[Event]:
        self.tasks.append(task)
        self.to_skip = to_skip
        for event in self.story:
            while should_wait() and not should_stop():
                threading.Event().wait(0.01)
            yield event
        if self.ending:
            raise self.ending
        waiting = threading.Event()
        while self.hold and not should_stop():
            waiting.wait(0.01)
        self.stopped = should_stop()

    def resume(
        self,
        task: Resumed,
        should_stop: Callable[[], bool],
        should_wait: Callable[[], bool],
        to_skip: Callable[[], tuple[int, int] | None],
    ) -> Iterator[Event]:
        self.resumed.append(task)
        self.story, self.hold = self.rest, False
        return self.learn(Task(task.log, Settings(), 0, 0, (), task.log), should_stop, should_wait, to_skip)

    def reproduce(self, runs: Runs, should_stop: Callable[[], bool]) -> Iterator[Film | Reproduced]:
        self.runs.append(runs)
        count = runs.starts.effective[0]
        for n in range(count):
            yield replace(scripted.film(n), purpose="reproduce")
        waiting = threading.Event()
        while self.hold and not should_stop():
            waiting.wait(0.01)
        if not should_stop():
            good = sum(scripted.film(n).success for n in range(count))
            yield Reproduced(good, count, *Success(good, count).interval, good >= 0.8 * count)

    def verify(self, check: Check, should_stop: Callable[[], bool]) -> Iterator[float | ReplayReport]:
        self.checks.append(check)
        yield 0.25
        waiting = threading.Event()
        while self.hold and not should_stop():
            waiting.wait(0.01)
        if not should_stop():
            yield self.report

    def observe(self, task: Task, should_stop: Callable[[], bool]) -> Iterator[Sighting | Demonstration]:
        self.watches.append(task)
        if self.unseen and len(self.watches) == 1:
            if self.late:
                yield scripted.sighting(lost=(0, 361))
            raise self.unseen
        yield scripted.sighting(TRACKED, lost=LOST)
        waiting = threading.Event()
        while self.hold and not self.watched and not should_stop():
            waiting.wait(0.01)
        if not should_stop():
            yield scripted.sighting(begin=TRACKED, lost=LOST)
            yield from self.noted
            yield scripted.demonstration()


def first_picture(_path: Path) -> np.ndarray:
    """A grey table with a bright spot in a corner, 64 × 48."""
    image = np.full((48, 64, 3), 90, np.uint8)
    image[:24] = np.linspace(40, 200, 64)[:, None].astype(np.uint8)
    image[30:40, 8:16], image[30:40, 40:48] = (220, 30, 20), (230, 210, 30)
    return image


async def until(pilot: Pilot[None], holds: Callable[[], bool], seconds: float = 20) -> None:
    """Wait for what a worker thread brings about."""
    ends = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < ends, f"it did not come about in {seconds} s"
        await pilot.pause(0.01)
    await pilot.pause()


async def drawn(pilot: Pilot[None]) -> None:
    """Wait until nothing is left to draw, and what is on the screen stays the same for a while."""
    before, same = None, 0
    while same < 8:
        await pilot.pause(0.1)
        await pilot.pause()
        now = [list(strip) for strip in pilot.app.screen._compositor.render_strips()]
        before, same = now, same + 1 if now == before else 0


def at(app: ImitateApp, step: str) -> Callable[[], bool]:
    """Whether a step is shown."""
    return lambda: app.step is not None and app.step.is_mounted and step == app.step.STEP


def kind_of(path: Path) -> str:
    if "broken" in path.name:
        raise FileError(path.name, "is no MCAP file (it begins with 'hello')", "Record it again.")
    return (
        "session"
        if path.parent.name == "sessions"
        else "recording"
        if ".mcap" in path.name
        else "demonstration"
    )


def look(path: Path) -> Preview:
    kind = kind_of(path)
    if kind == "recording":
        wrong = ("3 of 120 pictures are left out: no other within 0.04 s",)
        return Preview(kind, (("duration", "4.00 s"), ("rate", "30 a second")), wrong, first_picture(path))
    return Preview(kind, demonstration_facts(scripted.demonstration()) if kind == "demonstration" else ())


def decide(
    found: tuple[Segment, ...], decisions: tuple[Decision, ...], _demo: Demonstration, _settings: Settings
) -> tuple[Segment, ...]:
    """Moves, relabels, splits, merges, undoes and redoes; refuses what the real one would."""
    kept: list[Decision] = []
    undone: list[Decision] = []
    for decision in decisions:
        if decision.kind == "undo":
            undone.append(kept.pop())
        elif decision.kind == "redo":
            kept.append(undone.pop())
        else:
            kept.append(decision)
    segments = list(found)
    for d in kept:
        if d.kind == "move":
            if d.time > 7.5:
                raise UsageError(
                    f"{d.time:g} s leaves too little of skill {d.segment + 2}. Merge them instead."
                )
            segments[d.segment] = replace(segments[d.segment], end=d.time, human=True)
            segments[d.segment + 1] = replace(segments[d.segment + 1], start=d.time)
        elif d.kind == "split":
            one = segments[d.segment]
            parts = [replace(one, end=d.time, human=True), replace(one, start=d.time, human=True)]
            segments[d.segment : d.segment + 1] = parts
        elif d.kind == "merge":
            one, other = segments[d.segment : d.segment + 2]
            segments[d.segment : d.segment + 2] = [replace(one, end=other.end, human=True)]
        elif d.kind == "reset":
            segments = list(found)
        elif d.abstraction:
            segments[d.segment] = replace(segments[d.segment], abstraction=d.abstraction, human=True)
    return tuple(segments)


def changes(_demo: Demonstration, segments: tuple[Segment, ...], _settings: Settings) -> tuple[Interval, ...]:
    """Each from a little before the boundary to a little more after it."""
    return tuple((s.end - 0.25, s.end + 0.5) for s in segments[:-1])


def doubts(
    _demo: Demonstration, found: tuple[Segment, ...], segments: tuple[Segment, ...], _settings: Settings
) -> tuple[Doubt, ...]:
    """A relabelled skill, by its rank; a boundary, by 40 nats once it is a second off."""
    if len(found) != len(segments):
        return ()
    said = []
    for k, (before, now) in enumerate(zip(found, segments, strict=True)):
        likely = {c.abstraction: c.log_likelihood for c in now.alternatives}
        if now.abstraction != before.abstraction:
            ratio = likely[now.abstraction] - likely[before.abstraction]
            said.append(Doubt(k, k, ratio, f"for {now.abstraction}", f"for {before.abstraction}"))
        if abs(now.end - before.end) >= 1:
            said.append(Doubt(k, k + 1, -40.0, f"cut at {now.end:.2f} s", f"cut at {before.end:.2f} s"))
    return tuple(said)


def along(demo: Demonstration, _settings: Settings) -> Series:
    """Blue moves along while it is carried, and stays while the hand moves without it; green stays."""
    moving = demo.t >= 0
    carried = (demo.t > 4) & (demo.t < 8)
    return Series(demo.object_names, demo.t, (np.where(carried, 1.0, -1.0), np.where(moving, -1.0, 0.0)))


def scripted_app(
    root: Path,
    script: Script | None = None,
    source: str | None = "fixtures/stack.npz",
    display: bool = False,
    recorded: Iterable[Event] = tuple(scripted.session()),
) -> ImitateApp:
    """The application in a folder with a few files, with a file opened already unless ``source`` is None."""
    for name in (
        "fixtures/stack.npz",
        "fixtures/stack.mcap",
        "fixtures/broken.mcap",
        "sessions/stack-001.mcap",
    ):
        (root / name).parent.mkdir(exist_ok=True, parents=True)
        (root / name).touch()
    script = script or Script()
    engine = Engine(
        kind_of=kind_of,  # type: ignore[arg-type]
        look=look,
        read=lambda _path, _notes: scripted.demonstration(),
        cut=lambda _demonstration, _settings: scripted.segments(),
        decide=decide,
        changes=changes,
        doubts=doubts,
        along=along,
        pictures=lambda _wanted, _stop: (shot_of(n / 2, first_picture(Path())) for n in range(25)),
        split_time=lambda _demonstration, segment, _settings: (segment.start + segment.end) / 2,
        recorded=lambda _path: iter(recorded),
        first_picture=lambda path, _settings: first_picture(path),
        observe=script.observe,
        learn=script.learn,
        resume=script.resume,
        films=lambda _log, _stop: (scripted.film(n) for n in range(6)),
        reproduce=script.reproduce,
        verify=script.verify,
        view=lambda log, _stop: iter([log.with_suffix(".rrd")]),
        has_display=lambda: display,
        open_viewer=script.viewed.append,
    )
    app = ImitateApp(
        root / source if source else None, seed=3, engine=engine, root=root, photo=photo_of_terminal()
    )
    app.state.pace = Pace(count(step=0.5).__next__)  # two trials a second
    return app
