"""Objects that lie about and take no part change nothing of what is found."""

import numpy as np
import pytest
import scripted

from imitate.demonstration import Demonstration
from imitate.segmentation import segment
from imitate.segmentation.abstraction import log_prior
from imitate.segmentation.robust import RobustScore
from imitate.settings import load_settings

SETTINGS = load_settings().segmentation


def crowded(more):
    """The scripted demonstration in a sixth of its time, with so many objects more that lie about."""
    d, rng = scripted.demonstration(), np.random.default_rng(0)
    still = np.tile([0.0, 0, 0.02, 0, 0, 0, 1], (len(d.t), more, 1))
    still[..., :2] = rng.uniform(0.5, 3, (more, 2))
    return Demonstration(
        d.t[::6] / 6,
        d.hand[::6],
        np.concatenate([d.objects, still], axis=1)[::6],
        (*d.object_names, *(f"still {k}" for k in range(more))),
        np.concatenate([d.object_sizes, np.full((more, 3), 0.04)]),
    )


def test_hundreds_of_objects_forbid_no_cut():
    alone, among = (segment(crowded(more), SETTINGS) for more in (0, 200))
    assert [s.abstraction for s in among] == [s.abstraction for s in alone]
    assert [s.start for s in among] == pytest.approx([s.start for s in alone], abs=0.1)
    assert len(among) > 1


@pytest.mark.parametrize("more", [0, 1, 40])
def test_the_prior_counts_the_sets_of_what_may_go_along(more):
    assert RobustScore(crowded(more), SETTINGS).prior == log_prior(2 + more, 1)
    assert log_prior(2 + more, 1) == pytest.approx(-np.log(2 * (2 + more)))
    assert log_prior(3, 9) == log_prior(3) == pytest.approx(-np.log(3 * 4))
