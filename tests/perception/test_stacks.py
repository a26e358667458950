"""Things of two hues told apart."""

import numpy as np
import pytest

from imitate.perception.stacks import parts_by_hue

generator = np.random.default_rng(0)


def cube(at, side=0.04, count=1500, top=True):
    """Points on a cube's sides, and on its top where that can be seen; its lowest point is ``at``."""
    points = generator.uniform(-side / 2, side / 2, (count, 3))
    face = generator.integers(0, 5 if top else 4, count)
    points[np.arange(count), face // 2] = np.where(face % 2, -side / 2, side / 2)
    return points + np.asarray(at) + [0, 0, side / 2]


def painted(*degrees):
    return np.concatenate([(d + generator.normal(0, 4, 1500)) % 360 for d in degrees]).astype(np.float32)


@pytest.mark.parametrize("hues", [(225, 125), (2, 125), (350, 30), (358, 225)])
def test_a_stack_of_two_hues_is_two_parts_the_upper_standing_on_the_lower(hues):
    points = np.concatenate([cube([0, 0, 0.04]), cube([0, 0, 0], top=False)])
    upper, lower = (np.arange(1500), np.arange(1500, 3000))
    parts = parts_by_hue(points, painted(*hues))
    assert len(parts) == 2
    assert np.isin(parts[0].points, lower).mean() > 0.99 and parts[0].floor == 0
    assert np.isin(parts[1].points, upper).mean() > 0.99 and parts[1].floor == pytest.approx(0.04, abs=0.002)


def test_blocks_side_by_side_both_stand_on_the_table():
    points = np.concatenate([cube([0, 0, 0]), cube([0.041, 0, 0])])
    assert [part.floor for part in parts_by_hue(points, painted(225, 125))] == [0, 0]


def test_grey_points_go_to_the_nearest_colour():
    points, hue = np.concatenate([cube([0, 0, 0], top=False), cube([0, 0, 0.04])]), painted(225, 125)
    hue[::10] = np.nan
    parts = parts_by_hue(points, hue)
    assert sorted(np.concatenate([part.points for part in parts])) == list(range(3000))


@pytest.mark.parametrize("hues", [(0, 0), (355, 8), (115, 130)])
def test_one_hue_is_one_thing_also_across_the_circles_end(hues):
    points = np.concatenate([cube([0, 0, 0]), cube([0, 0, 0.04])])
    assert len(parts_by_hue(points, painted(*hues))) == 1


def test_a_pattern_is_one_thing():
    points = cube([0, 0, 0], count=3000)
    hue = np.where((np.floor(points / 0.012).astype(int).sum(axis=1)) % 2, 225, 30).astype(np.float32)
    assert len(parts_by_hue(points, hue)) == 1


def test_a_label_on_a_box_is_no_thing_of_its_own():
    points = cube([0, 0, 0], count=3000)
    label = (points[:, 0] > 0.0199) & (np.abs(points[:, 1:] - [0, 0.02]).max(axis=1) < 0.017)
    assert label.mean() > 0.1
    assert len(parts_by_hue(points, np.where(label, 225, 30).astype(np.float32))) == 1


def test_without_colour_there_is_one_part():
    points = cube([0, 0, 0])
    parts = parts_by_hue(points, np.full(1500, np.nan, np.float32))
    assert len(parts) == 1 and len(parts[0].points) == 1500
