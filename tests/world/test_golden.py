"""The numbers of one trial stay what they were: what the code is compared with is not the code itself."""

from __future__ import annotations

from collections.abc import Iterator

import golden
import numpy as np
import pytest

from imitate.record import TrialRecord
from imitate.session.versions import version_differences
from imitate.world.trial import Simulator

RECORD, MADE_WITH = golden.recorded()
CLOSE = 1e-9


@pytest.fixture(scope="module")
def simulator() -> Iterator[Simulator]:
    made = golden.simulator()
    yield made
    made.close()


def assert_close(found: TrialRecord) -> None:
    assert found.option_starts == RECORD.option_starts
    for field in golden.FIELDS:
        here, kept = getattr(found, field), getattr(RECORD, field)
        np.testing.assert_allclose(here, kept, rtol=CLOSE, atol=CLOSE, err_msg=field)


def test_it_says_something_of_a_grip_and_of_a_movement() -> None:
    assert RECORD.option_starts == (0, 132)
    assert RECORD.steps == 348
    assert RECORD.object_poses[-1, 0, 2] > 0.05
    assert RECORD.contact_forces[-1, 0] > 15
    assert np.abs(RECORD.joint_velocities).max() > 0.5


def test_its_commands_give_the_recorded_numbers(simulator: Simulator) -> None:
    found = simulator.resimulate(RECORD)
    assert_close(found)
    if not version_differences(MADE_WITH):  # elsewhere the last bits may be others
        for field in golden.FIELDS:
            assert getattr(found, field).tobytes() == getattr(RECORD, field).tobytes(), field


def test_its_policies_give_the_recorded_numbers(simulator: Simulator) -> None:
    outcome = simulator.run(golden.START, golden.POLICIES)
    assert (outcome.unreachable, outcome.unseen) == ("", "")
    assert_close(outcome.record)
