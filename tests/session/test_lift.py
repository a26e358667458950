"""Lifts that people have shown: learned from each seed, and judged here by the cube's height alone."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from imitate.events import TrialFinished
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.session_log import read_session

LIFT = Path(__file__).parents[2] / ".." / "shared" / "data" / "demonstrations" / "human_SawyerLift_demo_1.npz"
SEEDS = 10


@pytest.mark.slow
def test_a_persons_lift_is_learned_from_nine_of_ten_seeds_and_none_passes_on_the_table(tmp_path):
    if not LIFT.exists():
        pytest.skip("the shared demonstrations are not beside the project")
    program = "from imitate.cli import main; main()"
    told = subprocess.run(
        [
            sys.executable,
            "-c",
            program,
            "learn",
            str(LIFT),
            "--seeds",
            f"0-{SEEDS - 1}",
            "--no-rrd",
            "--json",
        ],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        check=False,
    ).stdout
    sessions = json.loads(told)["sessions"]
    assert sum(session["reproduced"] for session in sessions) >= 9
    shown = read_demonstration(LIFT).objects[:, 0, 2]
    for session in sessions:
        for event in read_session(tmp_path / session["session"]):
            if isinstance(event, TrialFinished) and event.purpose == "reproduce" and event.success:
                height = event.record.object_poses[:, 0, 2]
                assert height[-1] - height[0] > (shown[-1] - shown[0]) / 2
                assert np.ptp(height[-24:]) < 0.002
