"""A session as a Rerun recording: every step, by columns, a trial at a time.

Entities::

    world/arm                                       a line over its joints, 30 times a second
    world/hand, world/objects/NAME                  poses; the objects as boxes of their size
    seen/objects/NAME                               where the camera saw it, in trials that are watched
    camera/colour, camera/depth                     the recording, where the session keeps it
    demonstration/hand, demonstration/objects/NAME  what was shown, on the same clock, before the first trial
    robot/positions, robot/velocities               of each joint, rad and m, rad/s and m/s
    robot/commands                                  joint targets
    gripper/force                                   the commanded force in N; 0 is open
    contact/NAME                                    sum of the normal forces on an object, N
    costs/skill_I/formulation_K/PURPOSE             total cost of each trial
    log                                             what was decided and why

Timelines: "time", simulated seconds as in the session's log, and "trial", counting through the session.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from imitate.errors import FileError, ImitateError
from imitate.events import (
    Converged,
    Decided,
    Evaluated,
    Event,
    FormulationStarted,
    OptionLearned,
    Reformulated,
    Reproduced,
    Segmented,
    SessionFinished,
    SessionStarted,
    Skipped,
    TrialFinished,
)
from imitate.formats.output import refuse_existing
from imitate.formats.session_messages import Stamped
from imitate.record import SceneSpec
from imitate.session.view_columns import (
    clock_of,
    draw_scene,
    entity_of,
    send_arm,
    send_poses,
    send_record,
    send_seen,
)
from imitate.session.view_pictures import CAMERA, show_pictures
from imitate.world.skeleton import Skeleton

if TYPE_CHECKING:
    import rerun as rr

APPLICATION = "imitate"


class Viewer:
    """Writes an ``.rrd`` file while a session runs; a listener of the session's events.

    Nothing is sent anywhere but to the viewer program that ``spawn`` starts on this machine.

    Args:
        path: the new file.
        force: replace what is there.
        spawn: show the same in Rerun's viewer while it is written.
        pictures: a recording's messages, as `imitate.formats.session_pictures` makes them; None shows none.

    Raises:
        FileError: the file exists and ``force`` is not given, or, at the first event, it cannot be written.
        ImitateError: there is no display for the viewer.
    """

    def __init__(
        self,
        path: Path | str,
        force: bool = False,
        spawn: bool = False,
        pictures: Iterable[Stamped] | None = None,
    ) -> None:
        self.path = Path(path)
        refuse_existing(self.path, force)
        if spawn:
            _check_display(self.path)
        self._spawn, self._pictures = spawn, pictures
        self._recording: rr.RecordingStream | None = None
        self._scene: SceneSpec
        self._skeleton: Skeleton | None = None
        self._time = 0.0
        self._trials = 0

    def write(self, event: Event) -> None:
        """Adds one event; those before SessionStarted are not shown."""
        if isinstance(event, SessionStarted):
            self._start(event)
        if self._recording is None:
            return
        if isinstance(event, TrialFinished):
            self._show_trial(self._recording, event)
        elif text := _in_words(event):
            self._say(self._recording, text, "WARN" if isinstance(event, Reformulated) else "INFO")

    def close(self) -> None:
        """Finishes the file."""
        if self._recording is not None:
            self._recording.disconnect()
            self._recording = None

    def __enter__(self) -> Viewer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _start(self, event: SessionStarted) -> None:
        import rerun as rr

        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.write_bytes(b"")  # rerun would only log that it cannot
        except OSError as error:
            raise FileError(self.path, f"cannot be written ({error.strerror})") from error
        rr.set_strict_mode(True)  # else a mistake here would be a line in a log that nobody reads
        self._scene = event.scene
        identity = f"{event.source} seed {event.seed} {event.source_hash[:8]}"
        self._recording = rr.RecordingStream(APPLICATION, recording_id=identity, send_properties=False)
        sinks: list[Any] = [rr.FileSink(self.path)]
        if self._spawn:
            rr.spawn(connect=False)
            sinks.append(rr.GrpcSink())
        self._recording.set_sinks(*sinks, default_blueprint=_blueprint(self._pictures is not None))
        draw_scene(self._recording, event.scene)
        self._skeleton = _skeleton(event.scene)
        demonstration = event.demonstration
        times = demonstration.t - demonstration.t[0]
        bodies = {"hand": demonstration.hand}
        for k, name in enumerate(demonstration.object_names):
            bodies[entity_of(name)] = demonstration.objects[:, k]
        for name, poses in bodies.items():
            seen = ~np.isnan(poses[:, 0])
            send_poses(self._recording, f"demonstration/{name}", clock_of(times[seen]), poses[seen])
        if self._pictures is not None:
            show_pictures(self._recording, self._pictures)
        self._time = float(times[-1])
        self._say(self._recording, f"{event.source}, seed {event.seed}", "INFO")

    def _say(self, recording: rr.RecordingStream, text: str, level: str) -> None:
        import rerun as rr

        recording.set_time("time", duration=self._time)
        recording.log("log", rr.TextLog(text, level=level))

    def _show_trial(self, recording: rr.RecordingStream, event: TrialFinished) -> None:
        import rerun as rr

        if event.record is not None:
            send_record(recording, event.record, self._scene.object_names, self._time)
            if event.seen is not None:
                send_seen(recording, event.seen, event.record, self._scene.object_names, self._time)
            if self._skeleton:
                send_arm(recording, event.record, self._skeleton, self._time)
            self._time += event.record.steps * event.record.time_step
        here = [
            rr.TimeColumn("time", duration=[self._time]),
            rr.TimeColumn("trial", sequence=[self._trials]),
        ]
        entity = f"costs/skill_{event.segment + 1}/formulation_{event.formulation + 1}/{event.purpose}"
        recording.send_columns(entity, here, rr.Scalars.columns(scalars=[event.cost.total]))
        self._trials += 1


def _check_display(path: Path) -> None:
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise ImitateError(
            "--spawn: there is no display for Rerun's viewer. Leave it out, and look at the file where there "
            f"is one: rerun {path}"
        )


def _skeleton(scene: SceneSpec) -> Skeleton | None:
    # Without it where the robot's files are gone: an old log is still worth a look.
    try:
        return Skeleton(scene)
    except ImitateError:
        return None


def _blueprint(pictures: bool) -> Any:
    import rerun.blueprint as rrb

    camera = [rrb.Spatial2DView(origin=f"{CAMERA}/{k}", name=k.title()) for k in ("colour", "depth")]
    cameras = [rrb.Horizontal(*camera)] if pictures else []
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(origin="world", name="Trials"),
                *cameras,
                rrb.TextLogView(origin="log", name="Decisions"),
                row_shares=[3, *[1 for _ in cameras], 1],
            ),
            rrb.Vertical(
                rrb.TimeSeriesView(origin="costs", name="Costs"),
                rrb.TimeSeriesView(contents=["gripper/**", "contact/**"], name="Forces (N)"),
                rrb.TimeSeriesView(origin="robot/positions", name="Joints (rad, m)"),
            ),
        )
    )


def _in_words(event: Event) -> str:
    match event:
        case Segmented():
            return "segments: " + "; ".join(str(s.abstraction) for s in event.segments)
        case Decided():
            return f"the operator decided: {event.decision}"
        case FormulationStarted():
            f = event.formulation
            return f"skill {f.segment + 1}: {f.abstraction}, actions {' and '.join(f.actions)}: {f.reason}"
        case Converged() | Reformulated():
            return f"skill {event.segment + 1}: {event.reason}"
        case Skipped():
            return f"the operator skipped skill {event.segment + 1}'s formulation {event.formulation + 1}"
        case Evaluated():
            rate = f"{event.successes} of {event.trials}, {event.low:.0%} to {event.high:.0%}"
            verdict = "accepted" if event.accepted else "not accepted"
            return f"skill {event.segment + 1}: success in {rate}: {verdict}"
        case OptionLearned():
            return f"skill {event.segment + 1} is learned" + (
                f"; {event.initiation}" if event.initiation else ""
            )
        case Reproduced():
            return f"the whole task: success in {event.successes} of {event.trials}"
        case SessionFinished():
            return "reproduced" if event.reproduced else f"not reproduced. {event.advice}"
        case _:
            return ""
