"""Re-simulate a session from its recorded starts and commands, and compare every double bit for bit."""

from __future__ import annotations

import pickle
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError, UsageError
from imitate.events import SessionStarted, TrialFinished
from imitate.formats.session_log import SessionReader, summarise
from imitate.learning.trials import process_pool
from imitate.record import TrialRecord
from imitate.session.versions import version_differences
from imitate.settings import settings_from_toml
from imitate.world.robot_files import located
from imitate.world.scene import World
from imitate.world.trial import Simulator

Progress = Callable[[int, int], None]
"""called with the trials compared so far and those in the file."""
_AHEAD = 2
"""trials sent to each worker before the first of them is back: more would only fill memory."""
_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_VELOCITY = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True)
class Divergence:
    """Where a replay first differs from what was recorded.

    Attributes:
        step: physics step of the trial, from 0.
        segment, formulation, trial: of the trial, as in its TrialFinished.
        field: "joint_positions[3]" by joint, "object_poses[blue].z" by object.
        recorded, replayed: the two values.
    """

    step: int
    segment: int
    formulation: int
    trial: int
    field: str
    recorded: float
    replayed: float


@dataclass(frozen=True)
class ReplayReport:
    """What a replay found.

    Attributes:
        trials, steps: how many were compared.
        unrecorded: trials whose steps the file does not hold.
        divergent: steps in which any double differs.
        first_divergence: None when there is none.
        damage: what could not be read of the file.
        machine: what differs from the machine that recorded it, in words.
    """

    trials: int
    steps: int
    unrecorded: int
    divergent: int
    first_divergence: Divergence | None
    damage: tuple[str, ...] = ()
    machine: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Compared:
    steps: int
    divergent: int
    step: int = 0
    field: str = ""
    recorded: float = 0.0
    replayed: float = 0.0


Compare = Callable[[TrialRecord], _Compared]


def replay(
    path: Path | str, progress: Progress | None = None, workers: int = 1, robot: str = ""
) -> ReplayReport:
    """Builds the scene anew and runs every recorded trial again.

    Args:
        path: a session.
        progress: called after each trial.
        workers: processes; the report is the same for any number.
        robot: the TOML file beside which the robot's files are now, if not where they were.

    Raises:
        FileError: no session, an unreadable one, or one without recorded steps.
        SceneError: the robot's files are missing or are not those recorded.
    """
    path = Path(path)
    total = summarise(path).trials
    reader = SessionReader(path)
    events = reader.events()
    started = next(events, None)
    if not isinstance(started, SessionStarted):
        what = f": {reader.damage[0]}" if reader.damage else ""
        raise FileError(path, f"does not begin with a session's start{what}", "It cannot be replayed.")
    compare = partial(_compare, _scene_of(path, started, robot), started.scene.object_names)
    trials = (event for event in events if isinstance(event, TrialFinished))
    if workers == 1:
        compared: Iterable[tuple[TrialFinished, _Compared | None]] = (
            (trial, compare(trial.record) if trial.record else None) for trial in trials
        )
        return _report(path, reader, _counted(compared, progress, total), started)
    with process_pool(workers)() as executor:
        compared = _spread(executor, compare, trials, workers * _AHEAD)
        return _report(path, reader, _counted(compared, progress, total), started)


def differences(recorded: TrialRecord, replayed: TrialRecord) -> NDArray[np.bool_]:
    """(N, D) where the bits of two trials' states differ, all fields of a step side by side."""
    differ: NDArray[np.bool_] = _bits(recorded) != _bits(replayed)
    return differ


def column_names(record: TrialRecord, objects: Iterable[str]) -> list[str]:
    """What the columns of `differences` are, in words."""
    joints = range(record.joint_positions.shape[1])
    names = [f"{field}[{joint}]" for field in ("joint_positions", "joint_velocities") for joint in joints]
    names += [f"hand_poses.{part}" for part in _POSE]
    objects = list(objects)
    names += [f"object_poses[{name}].{part}" for name in objects for part in _POSE]
    names += [f"object_velocities[{name}].{part}" for name in objects for part in _VELOCITY]
    return names + [f"contact_forces[{name}]" for name in objects]


def _state(record: TrialRecord) -> NDArray[np.float64]:
    columns = [getattr(record, field).reshape(record.steps, -1) for field in TrialRecord.STATE_FIELDS]
    return np.ascontiguousarray(np.concatenate(columns, axis=1))


def _bits(record: TrialRecord) -> NDArray[np.uint64]:
    # as bits, a NaN equals itself and −0.0 does not equal 0.0
    return _state(record).view(np.uint64)


def _scene_of(path: Path, started: SessionStarted, robot: str) -> bytes:
    try:
        settings = settings_from_toml(started.settings)
    except UsageError as error:
        raise FileError(path, f"has settings that this imitate does not know ({error})") from None
    return pickle.dumps((located(started.scene, robot), settings))


def _compare(scene: bytes, objects: tuple[str, ...], recorded: TrialRecord) -> _Compared:
    replayed = _simulator(scene).resimulate(recorded)
    if replayed.steps != recorded.steps:  # the record has too few commands for its steps
        short = replayed.steps
        return _Compared(recorded.steps, recorded.steps - short, short, "steps", recorded.steps, short)
    differ = differences(recorded, replayed)
    rows = differ.any(axis=1)
    if not rows.any():
        return _Compared(recorded.steps, 0)
    step = int(np.argmax(rows))
    column = int(np.argmax(differ[step]))
    return _Compared(
        recorded.steps,
        int(np.count_nonzero(rows)),
        step,
        column_names(recorded, objects)[column],
        float(_state(recorded)[step, column]),
        float(_state(replayed)[step, column]),
    )


@lru_cache(maxsize=1)
def _simulator(scene: bytes) -> Simulator:
    spec, settings = pickle.loads(scene)
    return Simulator(World(spec, settings.world), settings)


def _spread(
    executor: Executor, compare: Compare, trials: Iterable[TrialFinished], ahead: int
) -> Iterator[tuple[TrialFinished, _Compared | None]]:
    waiting: deque[tuple[TrialFinished, Future[_Compared] | None]] = deque()
    for trial in trials:
        waiting.append((trial, executor.submit(compare, trial.record) if trial.record else None))
        if len(waiting) > ahead:
            first, future = waiting.popleft()
            yield first, future.result() if future else None
    for first, future in waiting:
        yield first, future.result() if future else None


def _counted(
    compared: Iterable[tuple[TrialFinished, _Compared | None]], progress: Progress | None, total: int
) -> Iterator[tuple[TrialFinished, _Compared | None]]:
    for done, pair in enumerate(compared, start=1):
        yield pair
        if progress:
            progress(done, total)


def _report(
    path: Path,
    reader: SessionReader,
    compared: Iterable[tuple[TrialFinished, _Compared | None]],
    started: SessionStarted,
) -> ReplayReport:
    trials = steps = unrecorded = divergent = 0
    first: Divergence | None = None
    for trial, result in compared:
        if result is None:
            unrecorded += 1
            continue
        trials += 1
        steps += result.steps
        divergent += result.divergent
        if result.divergent and first is None:
            where = (result.step, trial.segment, trial.formulation, trial.trial)
            first = Divergence(*where, result.field, result.recorded, result.replayed)
    if unrecorded and not trials:
        raise FileError(path, f"holds no steps of its {unrecorded} trials", "There is nothing to compare.")
    machine = version_differences(started.versions) if divergent else ()
    return ReplayReport(trials, steps, unrecorded, divergent, first, tuple(reader.damage), machine)
