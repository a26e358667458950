"""Replay: nothing differs where nothing was changed, and one unit in the last place is found where it is."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import recorded
import scripted

from imitate.errors import FileError, SceneError
from imitate.events import SessionStarted, TrialFinished
from imitate.formats.session_writer import SessionWriter
from imitate.geometry import resample
from imitate.record import TrialRecord
from imitate.session.compare import compare_steps
from imitate.session.replay import Part, replay
from imitate.session.versions import versions
from imitate.world.engine import data_path
from imitate.world.robot import description_of, load_robot
from imitate.world.robot_files import recorded_files
from imitate.world.scene import shown_start
from imitate.world.trial import Simulator

STEPS = 240


def grasp(simulator: Simulator, started: SessionStarted, lift: float) -> TrialRecord:
    """A real trial: the gripper closes around the block's place and goes where the person's hand went."""
    shown = started.demonstration
    hand = resample(shown.t, shown.hand, np.arange(STEPS // 4) / 60 * lift)
    joints = simulator.arm.solve(started.scene.base, hand, started.scene.home[:7]).joints
    forces = np.where(np.arange(STEPS // 4) > 10, 20.0, 0.0)
    objects = len(started.scene.object_names)
    nothing = np.zeros((STEPS, 9))
    asked = TrialRecord(
        start=shown_start(started.scene),
        time_step=1 / 240,
        control_every=4,
        option_starts=(0,),
        commands=np.column_stack([joints, forces]),
        joint_positions=nothing,
        joint_velocities=nothing,
        hand_poses=nothing[:, :7],
        object_poses=np.zeros((STEPS, objects, 7)),
        object_velocities=np.zeros((STEPS, objects, 6)),
        contact_forces=np.zeros((STEPS, objects)),
    )
    return simulator.resimulate(asked)


@pytest.fixture(scope="module")
def trials(simulator: Simulator, started: SessionStarted) -> list[TrialFinished]:
    return [
        replace(
            scripted.trial(1, 0, number, "explore", 0, 20.0, ""),
            record=grasp(simulator, started, 1 + number / 4),
        )
        for number in range(3)
    ]


def session(path: Path, started: SessionStarted, trials: list[TrialFinished]) -> Path:
    with SessionWriter(path) as log:
        for event in (started, *trials):
            log.write(event)
    return path


def own_robot(folder: Path, started: SessionStarted) -> SessionStarted:
    """The same session, its Panda described by a file beside a URDF and meshes of one's own."""
    shutil.copytree(data_path() / "franka_panda", folder)
    text = description_of("panda").replace("franka_panda/panda.urdf", "panda.urdf")
    (folder / "mine.toml").write_text(text)
    name = str(folder / "mine.toml")
    files = recorded_files(load_robot(name))
    return replace(started, scene=replace(started.scene, robot=name, description=text, robot_files=files))


def nudged(trial: TrialFinished, field: str, index: tuple[int, ...]) -> TrialFinished:
    """The trial with one recorded double changed by one unit in the last place."""
    assert trial.record is not None
    values = np.array(getattr(trial.record, field))
    values[index] = np.nextafter(values[index], np.inf)
    return replace(trial, record=replace(trial.record, **{field: values}))


def test_an_unchanged_session_has_no_divergent_step(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    done: list[tuple[int, int]] = []
    path = session(tmp_path / "s.mcap", started, trials)
    report = replay(path, progress=lambda trial, of: done.append((trial, of)))
    assert (report.steps, report.divergent, report.first_divergence) == (3 * STEPS, 0, None)
    assert done == [(1, 3), (2, 3), (3, 3)]
    contact = trials[0].record
    assert contact is not None
    assert contact.contact_forces.max() > 0, "a replay without contact would show little"


@pytest.mark.parametrize(
    ("field", "index", "name"),
    [
        ("joint_positions", (17, 3), "joint_positions[3]"),
        ("joint_velocities", (0, 8), "joint_velocities[8]"),
        ("hand_poses", (100, 6), "hand_poses.qw"),
        ("object_poses", (STEPS - 1, 0, 2), "object_poses[{0}].z"),
        ("object_poses", (50, 1, 4), "object_poses[{1}].qy"),
        ("object_velocities", (31, 1, 3), "object_velocities[{1}].wx"),
        ("contact_forces", (200, 0), "contact_forces[{0}]"),
    ],
)
def test_one_unit_in_the_last_place_is_named(
    tmp_path: Path,
    started: SessionStarted,
    trials: list[TrialFinished],
    field: str,
    index: tuple[int, ...],
    name: str,
) -> None:
    changed = nudged(trials[1], field, index)
    report = replay(session(tmp_path / "s.mcap", started, [trials[0], changed, trials[2]]))
    first = report.first_divergence
    assert first is not None
    assert (first.step, first.segment, first.trial) == (index[0], 1, 1)
    assert first.field == name.format(*started.scene.object_names)
    assert first.recorded == np.nextafter(first.replayed, np.inf)
    assert report.divergent == 1
    assert report.steps == 3 * STEPS


def test_a_changed_command_diverges_from_its_step_on(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    record = trials[0].record
    assert record is not None
    commands = np.array(record.commands)
    commands[20, 0] += 1e-9
    changed = replace(trials[0], record=replace(record, commands=commands))
    report = replay(session(tmp_path / "s.mcap", started, [changed]))
    assert report.first_divergence is not None
    assert report.first_divergence.step == 80
    assert report.divergent > 100


def test_two_workers_report_the_same(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    changed = nudged(trials[2], "joint_positions", (5, 0))
    path = session(tmp_path / "s.mcap", started, [*trials[:2], changed])
    assert replay(path, workers=2) == replay(path)


def test_a_machine_that_differs_is_named(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    elsewhere = replace(started, versions={**started.versions, "pybullet": "3.0.0"})
    report = replay(session(tmp_path / "s.mcap", elsewhere, [nudged(trials[0], "hand_poses", (0, 0))]))
    assert report.machine == (f"recorded with pybullet 3.0.0, replayed with {versions()['pybullet']}",)


def test_comparison_is_by_bits() -> None:
    record = recorded.record(steps=4)
    forces = np.array(record.contact_forces)
    forces[:] = 0.0
    forces[2, 1] = np.nan
    record = replace(record, contact_forces=forces)
    names = ("blue", "green")
    assert compare_steps(record, replace(record, contact_forces=forces.copy()), names).first is None
    minus = forces.copy()
    minus[3, 0] = -0.0
    found = compare_steps(record, replace(record, contact_forces=minus), names)
    assert (found.divergent, found.first.step, found.first.field) == (1, 3, "contact_forces[blue]")


def test_a_cut_session_replays_what_is_whole(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    whole = session(tmp_path / "s.mcap", started, trials).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: int(len(whole) * 0.7)])
    report = replay(cut)
    assert 0 < report.steps < 3 * STEPS
    assert report.divergent == 0
    assert "the end of the file is missing" in report.damage[0]


def test_without_steps_there_is_nothing_to_replay(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    bare = [replace(trial, record=None) for trial in trials]
    with pytest.raises(FileError, match=r"s.mcap: holds no steps of its 3 trials"):
        replay(session(tmp_path / "s.mcap", started, bare))


def test_a_robot_of_ones_own_is_replayed_without_its_description_and_after_it_has_moved(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    path = session(tmp_path / "s.mcap", own_robot(tmp_path / "arm", started), trials[:1])
    (tmp_path / "arm" / "mine.toml").unlink()
    assert replay(path).divergent == 0
    shutil.move(tmp_path / "arm", tmp_path / "moved")
    with pytest.raises(SceneError, match="the recorded robot is not here"):
        replay(path)
    assert replay(path, robot=str(tmp_path / "moved" / "mine.toml")).divergent == 0


def test_a_mesh_that_changed_is_not_replayed(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished]
) -> None:
    path = session(tmp_path / "s.mcap", own_robot(tmp_path / "arm", started), trials[:1])
    mesh = tmp_path / "arm" / "meshes" / "collision" / "finger.obj"
    mesh.write_text(mesh.read_text() + "\n# changed\n")
    with pytest.raises(SceneError, match=r"meshes/collision/finger.obj differs; its SHA-256 begins"):
        replay(path)


TIMED = replace(scripted.trial(1, 0, 4, "explore", 0, 20.0, ""), record=recorded.record(steps=40))
ENDED = 10
"""s on the session's clock; forty steps before, TIMED began."""


@pytest.mark.parametrize(
    ("begin", "end", "steps"),
    [
        (0, 40, (0, 40)),
        (5, 35, (5, 35)),
        (4.5, 40, (5, 40)),  # a step that began before is not from then on
        (0, 35.5, (0, 35)),  # one that ends after is not up to then
        (4.0000001, 35.0000001, (4, 35)),  # a clock's rounding is no step
        (-3, 99, (0, 40)),
        (50, 60, (50, 40)),  # none: it is over
        (-9, -1, (0, 0)),  # none: it has not begun
    ],
)
def test_from_and_to_take_whole_steps_that_lie_between(
    begin: float, end: float, steps: tuple[int, int]
) -> None:
    began = ENDED - 40 / 240
    part = Part(begin=began + begin / 240, end=began + end / 240)
    assert part.steps_of(TIMED, ENDED * 10**9) == steps


@pytest.mark.parametrize(
    ("part", "taken"),
    [
        (Part(), True),
        (Part(segment=1), True),
        (Part(segment=0), False),
        (Part(formulation=0, trial=4), True),
        (Part(formulation=1, trial=4), False),
        (Part(segment=1, formulation=0, trial=5), False),
    ],
)
def test_a_part_takes_the_trials_that_it_names(part: Part, taken: bool) -> None:
    assert part.steps_of(TIMED, ENDED * 10**9) == ((0, 40) if taken else (0, 0))
    assert part.steps_of(replace(TIMED, record=None), ENDED * 10**9) == (0, 0)


def test_a_part_is_named() -> None:
    assert str(Part(1, 0, 2, 3.5, 4.25)) == "segment 1, formulation 0, trial 2, 3.5 to 4.25 s"
    assert str(Part(segment=0)) == "segment 0"
    assert str(Part(end=2.0)) == "0 to 2 s"
    assert (Part().whole, Part(trial=0).whole, Part(begin=1.0).whole) == (True, False, False)
