"""What stands on what, and what hangs in the air."""

from dataclasses import replace

import numpy as np
import pytest
from test_places import STAYED, shown

from imitate.learning.support import hang_in_air, standing_on


def test_a_box_stands_on_the_one_that_it_touches():
    sizes = np.full((3, 3), 0.04)
    poses = np.tile([0.0, 0, 0.02, 0, 0, 0, 1], (3, 1))
    poses[1, 2] = 0.06
    poses[2, 0] = 0.2
    assert standing_on(poses, sizes).tolist() == [-1, 0, -1]
    poses[1, 2] = 0.068
    assert standing_on(poses, sizes).tolist() == [-1, -1, -1]


@pytest.mark.parametrize(("lift", "hangs"), [(0.03, ("a",)), (0.008, ()), (0.0, ())])
def test_what_is_lifted_hangs(lift, hangs):
    demonstration = shown(((0, 0, lift), 0), STAYED)
    assert hang_in_air(demonstration, ("a", "b"), 2.0) == hangs
    assert hang_in_air(demonstration, ("b",), 2.0) == ()
    assert hang_in_air(demonstration, ("a", "b"), 0.2) == ()


def test_what_is_put_on_another_does_not_hang():
    stacked = shown(((0.3, 0, 0.04), 0), STAYED)
    assert hang_in_air(stacked, ("a",), 2.0) == ()
    assert hang_in_air(stacked, ("a",), 1.0) == ("a",)


def test_of_what_has_no_size_nobody_knows():
    lifted = shown(((0, 0, 0.1), 0), STAYED)
    assert hang_in_air(replace(lifted, object_sizes=np.full((2, 3), np.nan)), ("a",), 2.0) == ()
