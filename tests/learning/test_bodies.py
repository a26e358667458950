"""What a trial's record says of one body."""

import numpy as np
import pytest

from imitate.learning.bodies import resting
from imitate.settings import Settings

LEARNING = Settings().learning


@pytest.mark.parametrize(
    ("off", "physics", "camera"), [(0.001, True, True), (0.004, False, True), (0.006, False, False)]
)
def test_a_body_rests_within_what_each_way_of_knowing_can_tell(off, physics, camera):
    poses = np.tile([0.0, 0, 0, 0, 0, 0, 1], (100, 1))
    poses[80:, 0] = off
    for observe_trials, rests in ((False, physics), (True, camera)):
        settings = LEARNING.model_copy(update={"observe_trials": observe_trials})
        assert resting(poses, 1 / 240, settings) == rests
