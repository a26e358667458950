"""Perturbed starts: honest, apart from one another, and stacks stay stacks."""

from dataclasses import replace

import numpy as np
import pytest

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
