"""The virtual demonstrator's performance: at rest in the end, with a smooth retreat and a hand that grips."""

import numpy as np
import pytest

from imitate.geometry import angle_between, rotate
from imitate.world.performance import OPEN, RETREAT, perform


def test_retreat_is_smooth_and_leaves_the_objects_alone(short_demonstration):
    whole = perform(short_demonstration).demonstration
    added = whole.t > short_demonstration.duration + 1e-9
    speed = np.linalg.norm(np.gradient(whole.hand[added, :3], whole.t[added], axis=0), axis=1)
    assert speed[0] < 0.01 and speed[-1] < 0.01 and speed.max() < 0.3
    np.testing.assert_allclose(whole.hand[-1, :3] - whole.hand[added][0, :3], RETREAT, atol=1e-6)
    late = added & (whole.t > whole.t[-1] - 1)
    assert np.ptp(whole.objects[late], axis=0).max() == 0


def test_last_block_rests_exactly_on_the_other(short_demonstration):
    whole = perform(short_demonstration).demonstration
    (a, b), sizes = whole.objects[-1], whole.object_sizes
    assert b[2] == pytest.approx(sizes[1, 2] / 2)
    assert a[2] == pytest.approx(sizes[1, 2] + sizes[0, 2] / 2)
    assert rotate(a[3:], [0, 0, 1.0])[2] == pytest.approx(1)
    assert angle_between(a, short_demonstration.objects[-1, 0]) < 0.05


def test_fingers_close_on_the_carried_block_only(short_demonstration):
    performance = perform(short_demonstration)
    d = performance.demonstration
    lifted = d.objects[:, 0, 2] > d.objects[0, 0, 2] + 0.05
    carried = lifted & (d.t < short_demonstration.duration - 0.5)
    assert np.all(performance.opening[carried] > d.object_sizes[0, 1])
    assert np.all(performance.opening[carried] < d.object_sizes[0, 1] * np.sqrt(2) + 0.002)
    assert performance.opening[0] == pytest.approx(OPEN)
    assert performance.opening[-1] == pytest.approx(OPEN)
