"""Single bits changed in what a session recorded: each is found, at its step and by its field."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scripted

from imitate.demonstration import interpolated
from imitate.events import SessionStarted, TrialFinished
from imitate.formats.session_writer import SessionWriter
from imitate.learning.problem import formulate
from imitate.learning.starts import perturbed_starts
from imitate.record import Start, TrialRecord
from imitate.segmentation import segment
from imitate.session.compare import column_names
from imitate.session.replay import replay
from imitate.settings import Settings
from imitate.skill import Formulation, Policy
from imitate.world.trial import Simulator

DURATION = 0.8
"""s, of a carry that was shown in 5."""
MANY = pytest.param(200, marks=pytest.mark.slow)


@pytest.fixture(scope="module")
def policy(started: SessionStarted) -> Policy:
    """The carry with the gripper, so fast that it takes little time to simulate."""
    demonstration, settings = interpolated(started.demonstration), Settings()
    segments = segment(demonstration, settings.segmentation)
    formulation = Formulation(0, 0, segments[0].abstraction, ("pose", "gripper"), "")
    imitated = formulate(demonstration, segments, formulation, settings).imitated
    return replace(imitated, duration=DURATION)


def recorded_trial(
    simulator: Simulator, policy: Policy, start: Start, rng: np.random.Generator
) -> TrialFinished:
    """A real trial with parameters of its own."""
    weights = rng.normal(0, 20, policy.gripper_weights.shape)
    own = replace(policy, gripper_weights=weights)
    record = simulator.run(start, (own,)).record
    return replace(scripted.trial(0, 0, 0, "explore", 0, 20.0, ""), policies=(own,), record=record)


@pytest.fixture(scope="module")
def trials(simulator: Simulator, policy: Policy, started: SessionStarted) -> list[TrialFinished]:
    seeds = np.random.SeedSequence(5)
    starts = perturbed_starts(started.scene, 8, seeds, Settings())
    rng = np.random.default_rng(seeds)
    return [recorded_trial(simulator, policy, start, rng) for start in starts]


def session(folder: Path, started: SessionStarted, trial: TrialFinished) -> Path:
    path = folder / "s.mcap"
    with SessionWriter(path, force=True) as log:
        log.write(started)
        log.write(trial)
    return path


def with_a_bit_changed(
    trial: TrialFinished, field: str, rng: np.random.Generator
) -> tuple[TrialFinished, int, int]:
    """The trial, and the row and column of the double that changed."""
    assert trial.record is not None
    values = np.array(getattr(trial.record, field))
    flat = values.reshape(len(values), -1)
    row, column = int(rng.integers(flat.shape[0])), int(rng.integers(flat.shape[1]))
    flat.view(np.uint64)[row, column] ^= np.uint64(1) << np.uint64(rng.integers(64))
    return replace(trial, record=replace(trial.record, **{field: values})), row, column


@pytest.mark.parametrize("count", [6, MANY])
def test_a_bit_of_a_state_is_found_by_physics(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished], count: int
) -> None:
    rng = np.random.default_rng(0)
    assert trials[0].record is not None
    widths = [getattr(trials[0].record, field)[0].size for field in TrialRecord.STATE_FIELDS]
    names = column_names(trials[0].record, started.scene.object_names)
    for k in range(count):
        which = k % len(widths)
        field = TrialRecord.STATE_FIELDS[which]
        changed, row, column = with_a_bit_changed(trials[k % len(trials)], field, rng)
        report = replay(session(tmp_path, started, changed))
        assert report.first_divergence is not None
        assert report.first_divergence.step == row
        assert report.first_divergence.field == names[sum(widths[:which]) + column]
        assert report.divergent == 1


@pytest.mark.parametrize("count", [4, MANY])
def test_a_bit_of_a_command_is_found_by_the_policy(
    tmp_path: Path, started: SessionStarted, trials: list[TrialFinished], count: int
) -> None:
    rng = np.random.default_rng(1)
    for k in range(count):
        changed, row, column = with_a_bit_changed(trials[k % len(trials)], "commands", rng)
        assert changed.record is not None
        report = replay(session(tmp_path, started, changed), depth="policy")
        assert report.first_divergence is not None
        assert report.first_divergence.step == row * changed.record.control_every
        joint = f"joint {column}" if column < changed.record.commands.shape[1] - 1 else "force"
        assert report.first_divergence.field == f"commands[{joint}]"
        assert report.divergent == 1


@pytest.mark.parametrize("count", [2, MANY])
def test_what_was_not_changed_passes(
    tmp_path: Path,
    simulator: Simulator,
    policy: Policy,
    started: SessionStarted,
    count: int,
) -> None:
    seeds = np.random.SeedSequence(6)
    rng = np.random.default_rng(seeds)
    for start in perturbed_starts(started.scene, count, seeds, Settings()):
        path = session(tmp_path, started, recorded_trial(simulator, policy, start, rng))
        for depth in ("physics", "policy"):
            report = replay(path, depth=depth)
            assert report.steps > 30
            assert (report.divergent, report.first_divergence) == (0, None)
