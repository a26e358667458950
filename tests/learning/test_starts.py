"""Perturbed starts: honest, apart from one another, and stacks stay stacks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imitate.errors import ImitateError
from imitate.geometry import angle_between, compose, relative
from imitate.learning.starts import perturbed_starts
from imitate.learning.support import standing_on
from imitate.settings import Settings, load_settings
from imitate.world.scene import scene_of

SETTINGS = Settings()


@pytest.fixture(scope="module")
def spec(short_demonstration):
    return scene_of(short_demonstration, SETTINGS.world)


@pytest.fixture(scope="module")
def stacked(spec):
    """The first object on the second, turned by 30° and 8 mm off its middle."""
    low, sizes = spec.object_poses[1], spec.object_sizes
    half = np.deg2rad(15)
    height = (sizes[0, 2] + sizes[1, 2]) / 2
    on_top = compose(low, [0.008, 0, height, 0, 0, np.sin(half), np.cos(half)])
    return replace(spec, object_poses=np.array([on_top, low]))


def starts(spec, seed=0, count=30, settings=SETTINGS):
    return perturbed_starts(spec, count, np.random.SeedSequence(seed), settings)


def test_every_object_moves_within_its_bounds(spec):
    poses = np.array([s.objects for s in starts(spec)])
    off = poses[..., :3] - spec.object_poses[None, :, :3]
    turned = np.rad2deg(angle_between(poses, np.broadcast_to(spec.object_poses, poses.shape)))
    assert np.abs(off[..., :2]).max() <= 0.02
    assert np.abs(off[..., :2]).max() > 0.015
    assert np.all(off[..., 2] == 0)
    assert turned.max() <= 15.0 + 1e-6
    assert turned.max() > 10


def test_objects_move_and_turn_either_way_and_stand_as_they_stood(spec):
    made = starts(spec)
    poses = np.array([s.objects for s in made])
    off = (poses - spec.object_poses)[..., :2]
    assert off.min() < -0.015 < 0.015 < off.max()
    assert np.abs(off.mean(axis=0)).max() < 0.007
    turned = (
        Rotation.from_quat(poses[..., 3:].reshape(-1, 4))
        * Rotation.from_quat(np.tile(spec.object_poses[:, 3:], (len(made), 1))).inv()
    )
    about = np.rad2deg(turned.as_rotvec())
    np.testing.assert_allclose(about[:, :2], 0, atol=1e-9)
    assert about[:, 2].min() < -10 < 10 < about[:, 2].max()
    assert {tuple(s.joints) for s in made} == {tuple(spec.home)}
    assert {s.force for s in made} == {0.0}


def test_a_tower_moves_as_one_whatever_the_order_of_its_objects(spec):
    sizes = np.full((3, 3), 0.04)
    heights = {0: 0.10, 1: 0.02, 2: 0.06}  # the middle one comes last
    poses = np.array([[0.5, 0, heights[k], 0, 0, 0, 1] for k in range(3)])
    tower = replace(
        spec, object_names=("c", "a", "b"), object_sizes=sizes, object_masses=np.ones(3), object_poses=poses
    )
    assert standing_on(poses, sizes).tolist() == [2, -1, 1]
    for start in starts(tower):
        shown, now = (relative(p[[1, 2]], p[[2, 0]]) for p in (poses, start.objects))
        np.testing.assert_allclose(now, shown, atol=1e-12)


def test_objects_that_cannot_be_kept_apart_are_said(spec):
    grid = [[0.5 + x, y, 0.02, 0, 0, 0, 1] for x in (0, 0.045, 0.09) for y in (0, 0.045, 0.09)]
    crowd = replace(
        spec,
        object_names=tuple("abcdefghi"),
        object_sizes=np.full((9, 3), 0.04),
        object_masses=np.ones(9),
        object_poses=np.array(grid),
    )
    words = (
        "no start with every object moved by up to 2 cm keeps the objects apart; .* learning.shift smaller"
    )
    with pytest.raises(ImitateError, match=words):
        starts(crowd, count=1)


def test_the_same_seed_gives_the_same_starts(spec):
    a, b, c = starts(spec), starts(spec), starts(spec, seed=1)
    assert all(np.array_equal(x.objects, y.objects) for x, y in zip(a, b, strict=True))
    assert not any(np.array_equal(x.objects, y.objects) for x, y in zip(a, c, strict=True))


def test_objects_never_come_to_stand_in_one_another(spec):
    wide = load_settings(None, {"learning": {"shift": 0.1, "turn": 45.0}})
    gaps = [np.linalg.norm(s.objects[0, :2] - s.objects[1, :2]) for s in starts(spec, settings=wide)]
    clear = np.linalg.norm(spec.object_sizes[:, :2], axis=1).sum() / 2
    assert min(gaps) >= clear


def test_what_stands_on_what_is_seen_in_the_scene(spec, stacked):
    assert standing_on(spec.object_poses, spec.object_sizes).tolist() == [-1, -1]
    assert standing_on(stacked.object_poses, stacked.object_sizes).tolist() == [1, -1]


def test_what_stands_on_another_goes_with_it(stacked):
    shown = relative(stacked.object_poses[1], stacked.object_poses[0])
    below = []
    for start in starts(stacked):
        assert np.allclose(relative(start.objects[1], start.objects[0]), shown, atol=1e-12)
        below.append(start.objects[1])
    assert np.ptp(below, axis=0)[:2].min() > 0.02
