"""Other tasks than stacking, as cameras of different kinds see them: every skill, exactly."""

import numpy as np
import pytest
from showing import CAMERAS, TASKS, film
from stacking import Stacking, is_right, perform

from imitate.segmentation import segment
from imitate.settings import load_settings

ROBUST = load_settings().segmentation


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("task", TASKS)
def test_every_skill_is_found_exactly(task, camera):
    rng = np.random.default_rng([3, len(task), len(camera)])
    shown = TASKS[task](rng)
    found = segment(film(shown, CAMERAS[camera], rng), ROBUST)
    assert tuple(str(s.abstraction) for s in found) == shown.skills


@pytest.mark.parametrize("task", ["sorting four", "door about its origin", "touch and stack"])
@pytest.mark.parametrize("rate", [10.0, 60.0, 100.0])
def test_cuts_lie_at_the_same_seconds_at_any_frame_rate(task, rate):
    cuts = []
    for camera in (CAMERAS["exact"], type(CAMERAS["exact"])(rate=rate)):
        rng = np.random.default_rng(4)
        cuts.append([s.start for s in segment(film(TASKS[task](rng), camera, rng), ROBUST)])
    assert cuts[1] == pytest.approx(cuts[0], abs=0.35)


@pytest.mark.parametrize("noise", [0.002, 0.005, 0.008])
def test_a_long_pause_does_not_end_a_carry(noise):
    shown, times = perform(Stacking(noise=noise, mid_pause=12.0), np.random.default_rng(5))
    assert is_right(segment(shown, ROBUST), times, 0.6)
