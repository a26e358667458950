"""The example session that ships with imitate still comes out of the present code, bit for bit."""

from __future__ import annotations

from pathlib import Path

import pytest
from refiled import cut

from imitate.formats.session_log import read_session
from imitate.learning.trials import executors
from imitate.session.again import read_opening
from imitate.session.replay import Part, replay
from imitate.session.rerun import rerun
from imitate.session.versions import version_differences

EXAMPLE = Path(__file__).parents[2] / "sessions" / "stack.mcap"
SHARE = 0.06
"""of the file: the whole takes minutes."""

pytestmark = pytest.mark.skipif(not EXAMPLE.exists(), reason="sessions/stack.mcap is not there")


@pytest.fixture(scope="module")
def beginning(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its first trials, as they lie in the file."""
    path = cut(EXAMPLE, tmp_path_factory.mktemp("example") / "beginning.mcap", SHARE)
    if differences := version_differences(read_opening(path).started.versions):
        pytest.skip(f"{'; '.join(differences)}: the last bits may be others")
    return path


def test_seed_settings_and_demonstration_give_the_same_events_and_messages(beginning: Path) -> None:
    report = rerun(beginning, executors(0))
    assert report.first_divergence is None
    assert report.divergent == 0
    assert report.events == sum(1 for _ in read_session(beginning)) > 4


@pytest.mark.parametrize("depth", ["physics", "policy"])
def test_a_trial_of_each_depth_gives_the_recorded_steps(beginning: Path, depth: str) -> None:
    report = replay(beginning, depth=depth, part=Part(trial=0))
    assert report.first_divergence is None
    assert report.trials > 0
    assert report.steps > 100
