"""A session from its source to its reproduction: one stream of events, written to the log on its way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from imitate import events
from imitate.demonstration import TABLE, in_table_frame, interpolated
from imitate.errors import DemonstrationError, FileError, SceneError, UnknownNameError
from imitate.events import Event
from imitate.formats.kind import kind_of
from imitate.formats.mapping import Mapping
from imitate.formats.recordings import open_recording
from imitate.formats.session_messages import Stamped
from imitate.formats.session_pictures import pictures_of
from imitate.formats.session_writer import SessionWriter
from imitate.learning.problem import check_durations
from imitate.learning.trials import ExecutorFactory, Skip, Trials, executors, nothing_is_skipped
from imitate.session.course import course, segmented
from imitate.session.size import check_room, expected_bytes
from imitate.session.source import Source, Watching, read_source
from imitate.session.versions import versions
from imitate.settings import Settings, to_toml
from imitate.skill import Decision
from imitate.world.scene import check_grasps, check_within_reach, scene_of
from imitate.world.trial_camera import trial_paints


@dataclass(frozen=True)
class Request:
    """What to learn, and how.

    Attributes:
        source: a demonstration or a recording.
        workers: processes that run trials; 0 for the present one.
        decisions: the operator's, applied to the segments as found.
        mapping: what the source's columns, topics or frames mean, where their names do not say so.
        log: where the session is written; None writes none.
        rrd: where the viewer's file is written; None writes none.
        force: overwrite both.
        cluster: address of a scheduler whose workers run the trials instead; empty for none.
        steps: whether the log keeps every step of every trial.
        embed: keep the recording's pictures in the log.
        spawn: show what is written for Rerun in its viewer, as it comes; needs ``rrd``.
    """

    source: Path
    settings: Settings
    seed: int
    workers: int = 1
    decisions: tuple[Decision, ...] = ()
    mapping: Mapping | None = None
    log: Path | None = None
    rrd: Path | None = None
    force: bool = False
    cluster: str = ""
    steps: bool = True
    embed: bool = False
    spawn: bool = False


def run(
    request: Request,
    should_stop: Callable[[], bool] = lambda: False,
    watching: Watching | None = None,
    skip: Skip = nothing_is_skipped,
    factory: ExecutorFactory | None = None,
    heard: Callable[[Source], None] = lambda _: None,
) -> Iterator[Event]:
    """The session's events, each in the log before it is seen here.

    Args:
        request: what to do.
        should_stop: asked after each event; true ends the session there, its log valid.
        watching: hears of (frames done, frames in all) while a recording is observed.
        skip: asked after each batch of trials whether its formulation is given up.
        factory: of what runs the trials, where that is not for ``request`` to say.
        heard: hears of the source once it is read, before the first event.

    Raises:
        ImitateError: the source, the settings or the scene is not one to learn from.
    """
    if request.embed and kind_of(request.source) != "recording":
        raise FileError(
            request.source, "is no recording, and has no pictures to embed", "Leave --embed-recording out."
        )
    source = read_source(request.source, request.settings, request.seed, watching, request.mapping)
    heard(source)
    request = replace(request, settings=_settings_for(source, request.settings))
    with ExitStack() as stack:
        listeners: list[Callable[[Event], None]] = []
        for event in _course(request, source, stack, skip, factory):
            if not listeners and (request.log or request.rrd):
                listeners = _listeners(request, stack)
            for write in listeners:
                write(event)
            yield event
            if should_stop():
                return


def _settings_for(source: Source, settings: Settings) -> Settings:
    # What cannot be told from itself turned, by the operator and, but for the paper's mode, by the tracker.
    names, learning = source.demonstration.object_names, settings.learning
    for name in learning.symmetric:
        if name not in names:
            raise UnknownNameError(f"symmetric object of {source.name}:", name, names)
    seen = () if settings.mode == "faithful" else source.symmetric
    symmetric = tuple(name for name in names if name in (*learning.symmetric, *seen))
    return settings.model_copy(update={"learning": learning.model_copy(update={"symmetric": symmetric})})


def _listeners(request: Request, stack: ExitStack) -> list[Callable[[Event], None]]:
    # Opened at the first event, so that a source that fails leaves no empty file.
    found: list[Callable[[Event], None]] = []
    if request.log:
        pictures = _pictures(request) if request.embed else None
        log = SessionWriter(request.log, request.force, request.steps, pictures)
        found.append(stack.enter_context(log).write)
    if request.rrd:
        from imitate.session.viewer import Viewer  # rerun takes 0.4 s to import

        viewer = Viewer(
            request.rrd, request.force, request.spawn, _pictures(request) if request.embed else None
        )
        stack.callback(viewer.close)
        found.append(viewer.write)
    return found


def _pictures(request: Request) -> Iterator[Stamped]:
    # Read once more: while the recording is observed no picture is kept.
    return pictures_of(open_recording(request.source, request.settings.perception))


def _bytes_of_pictures(request: Request) -> int:
    # Depth as it is, two bytes a pixel, outweighs its compression and the colour.
    recording = open_recording(request.source, request.settings.perception)
    return 2 * recording.count * recording.intrinsics.width * recording.intrinsics.height


def _opening(request: Request, source: Source) -> list[Event]:
    # What is known before any trial. All that can be wrong with the input is found before the first event,
    # which opens the files.
    settings = request.settings
    demonstration = in_table_frame(source.demonstration)
    scene = scene_of(interpolated(demonstration), settings.world)
    told = segmented(demonstration, request.decisions, settings)
    segments = told[-1].segments
    check_durations(segments, settings)
    check_within_reach(
        scene,
        [n for s in segments for n in (*s.abstraction.carried, s.abstraction.reference) if n != TABLE],
    )
    check_grasps(scene, interpolated(demonstration), segments)
    if settings.learning.observe_trials:
        trial_paints(scene.object_names)
    started = events.SessionStarted(
        source.name, source.hash, request.seed, to_toml(settings), versions(), demonstration, scene
    )
    return [started, *told]


def _course(
    request: Request, source: Source, stack: ExitStack, skip: Skip, factory: ExecutorFactory | None
) -> Iterator[Event]:
    try:
        opening = _opening(request, source)
    except (DemonstrationError, SceneError) as error:
        raise type(error)(f"{request.source}: {error}") from error
    factory = factory or executors(request.workers, request.cluster)
    started, settled = opening[0], opening[-1]
    assert isinstance(started, events.SessionStarted)
    assert isinstance(settled, events.Segmented | events.Decided)
    if request.log:
        expected = expected_bytes(settled.segments, started.scene, request.settings, request.steps)
        expected += _bytes_of_pictures(request) if request.embed else 0
        check_room(request.log, expected)
    yield from opening
    trials = stack.enter_context(Trials(factory, started.scene, request.settings, skip))
    yield from course(started, settled.segments, trials)
