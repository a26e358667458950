"""What may be hidden of a thing: said of an end that is not known, and of an edge that something cuts off."""

import numpy as np
import pytest

from imitate.perception.hidden import cut_off, hidden_end
from imitate.perception.shapes import Pixels


def picture(depth):
    """Pixels (80 × 80) of a camera that looks straight down from 1 m, at these depths."""
    u, v = np.meshgrid(np.arange(80), np.arange(80))
    rays = np.stack([(u - 39.5) / 525, (v - 39.5) / 525, np.ones_like(u)], axis=-1).reshape(-1, 3)
    flipped = (rays * [1, -1, -1]).astype(np.float32)
    return Pixels(np.array([0, 0, 1.0]), flipped, depth.reshape(-1).astype(np.float32), np.full(6400, np.nan))


@pytest.mark.parametrize(("before", "cut"), [(0.8, True), (0.95, False)])
def test_an_edge_is_cut_off_by_what_stands_before_it_alone(before, cut):
    depth = np.full((80, 80), 1.0)
    depth[20:60, 20:60], depth[20:60, 60:75] = 0.9, before
    strange = np.zeros((80, 80), bool)
    strange[20:60, 60:75] = True
    own = np.flatnonzero(depth.reshape(-1) == 0.9)
    words = cut_off(picture(depth), own, strange.reshape(-1), 0.01)
    assert ("it may go on behind something unsure that stands before" in words) == cut
    assert cut_off(picture(depth), own, np.zeros(6400, bool), 0.01) == ""


def test_an_end_that_is_not_known_is_said():
    assert hidden_end(np.array([0.004, 0.01, 0.002])) == ""
    assert "a side is known to ± 64 mm only" in hidden_end(np.array([0.004, 0.064, 0.002]))
