"""The virtual camera: what it draws is where its intrinsics say, as noisy as a Kinect."""

import numpy as np
import pytest

from imitate.geometry import rotate
from imitate.world.demonstrator import film, plan_film
from imitate.world.engine import pybullet as bullet
from imitate.world.kinect import Camera, kinect_intrinsics, take
from imitate.world.performance import perform
from imitate.world.sensor import axial_noise

CAMERA = Camera(kinect_intrinsics(320, 240), np.array([0.12, -0.16, 0.8, 1.0, 0, 0, 0]))


@pytest.fixture
def client():
    client = bullet.connect(bullet.DIRECT)
    shape = bullet.createVisualShape(
        bullet.GEOM_BOX, halfExtents=[1, 1, 0.1], rgbaColor=[0.5, 0.5, 0.5, 1], physicsClientId=client
    )
    bullet.createMultiBody(0, -1, shape, [0, 0, -0.1], physicsClientId=client)
    shape = bullet.createVisualShape(
        bullet.GEOM_BOX, halfExtents=[0.05, 0.04, 0.1], rgbaColor=[0, 0, 1, 1], physicsClientId=client
    )
    bullet.createMultiBody(0, -1, shape, [0.13, -0.15, 0.1], physicsClientId=client)
    yield client
    bullet.disconnect(client)


def test_block_is_seen_where_it_stands(client):
    frame = take(client, CAMERA, 0.0, np.random.default_rng(0))
    pose = CAMERA.world_from_camera
    points = pose[:3] + rotate(pose[3:], CAMERA.intrinsics.rays() * frame.depth[..., None])
    block = points[frame.colour[..., 2] > 2.0 * frame.colour[..., 0]]
    pixel = 0.6 / CAMERA.intrinsics.fx
    np.testing.assert_allclose(block[:, :2].min(axis=0), [0.08, -0.19], atol=pixel + 0.001)
    np.testing.assert_allclose(block[:, :2].max(axis=0), [0.18, -0.11], atol=pixel + 0.001)
    assert np.mean(block[:, 2]) == pytest.approx(0.2, abs=2e-4)


def test_noise_is_a_kinects_and_follows_the_seed(client):
    one, same, other = (take(client, CAMERA, 0.0, np.random.default_rng(s)).depth for s in (3, 3, 4))
    table = one > 0.7
    np.testing.assert_array_equal(one, same)
    spread = np.std((one - other)[table].astype(float)) / np.sqrt(2)
    assert spread == pytest.approx(float(axial_noise(np.array(0.8))), rel=0.05)


def test_no_reading_nearer_than_a_kinect_reads(client):
    near = Camera(CAMERA.intrinsics, np.array([0.13, -0.15, 0.5, 1.0, 0, 0, 0]))
    depth = take(client, near, 0.0, np.random.default_rng(0)).depth
    assert depth[120, 160] == 0
    assert depth[2, 2] == pytest.approx(0.5, abs=0.01)


def test_film_shows_every_block_and_finger(short_demonstration):
    from imitate.settings import Perception

    plan = plan_film(perform(short_demonstration), 160, 120, 2)
    frames = list(film(plan, Perception(), seed=0))
    assert [frame.t for frame in frames] == pytest.approx(plan.performance.demonstration.t)
    red, green, blue = np.moveaxis(frames[0].colour.astype(int), -1, 0)
    assert ((blue > 2 * red) & (blue > 2 * green)).sum() > 20
    assert ((green > 2 * red) & (green > 2 * blue)).sum() > 20
    assert ((red > 2 * green) & (red > 2 * blue)).sum() > 10
    assert ((red > 2 * blue) & (green > 2 * blue)).sum() > 10
