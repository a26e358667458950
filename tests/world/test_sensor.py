"""The sensor's model against what was published and against geometry."""

import numpy as np
import pytest

from imitate.rgbd import Intrinsics
from imitate.world.kinect import kinect_intrinsics
from imitate.world.sensor import AXIAL, KINECT, Sensor, axial_noise, incidence, read_depth, shadowed

EYE = kinect_intrinsics(320, 240)
GREY = np.full((240, 320, 3), 128, np.uint8)
QUIET = Sensor(
    angled=False, lateral=0, step=0, baseline=0, flying=0, grazing=(90, 91), dark=0, glare=2, holes=0
)


def read(depth, sensor, seed=0, colour=GREY):
    return read_depth(depth, colour, EYE, sensor, np.random.default_rng(seed))


def tilted(degrees, at=0.8):
    """(H, W) depth of a plane through the axis at ``at`` metres, its normal turned about x."""
    normal = np.array([0, np.sin(np.deg2rad(degrees)), np.cos(np.deg2rad(degrees))])
    return normal[2] * at / (EYE.rays() @ normal)


def step_edge(near=0.6, far=0.9):
    depth = np.full((240, 320), far)
    depth[80:160, 120:200] = near
    return depth


@pytest.mark.parametrize("degrees", [0, 30, 60, 75])
def test_incidence_of_a_plane_is_exact(degrees):
    plane = tilted(degrees)
    normal = np.array([0, np.sin(np.deg2rad(degrees)), np.cos(np.deg2rad(degrees))])
    rays = EYE.rays()
    real = np.arccos(rays @ normal / np.linalg.norm(rays, axis=-1))
    seen = (plane > 0.3) & (plane < 3) & (real < np.deg2rad(80))
    found = incidence(plane.astype(np.float32), EYE)
    np.testing.assert_allclose(found[seen], real[seen], atol=0.03)


@pytest.mark.parametrize("depth", [0.6, 0.9, 1.5])
def test_noise_of_a_plane_seen_head_on_is_nguyens(depth):
    noisy = read(np.full((240, 320), depth), Sensor(step=0, holes=0, flying=0))
    assert np.std(noisy[noisy > 0].astype(float)) == pytest.approx(float(axial_noise(depth)), rel=0.03)


def test_noise_grows_beyond_sixty_degrees():
    plane = tilted(72)
    middle = np.s_[118:122, :]
    spread = {
        sensor: np.std([(read(plane, sensor, seed) - plane)[middle] for seed in range(8)])
        for sensor in (QUIET, Sensor(step=0, baseline=0, holes=0, flying=0, grazing=(90, 91)))
    }
    flat, steep = spread.values()
    theta = np.deg2rad(72)
    grown = axial_noise(0.8) + 0.0001 / np.sqrt(0.8) * theta**2 / (np.pi / 2 - theta) ** 2
    assert steep == pytest.approx(float(grown), rel=0.1) and steep > 1.5 * flat


@pytest.mark.parametrize("depth", [0.7, 1.1])
def test_steps_are_khoshelhams(depth):
    values = np.unique(read(np.full((240, 320), depth), KINECT))
    steps = np.diff(values[values > 0])
    np.testing.assert_allclose(steps, 2.85e-3 * depth**2, rtol=0.06)


def test_shadow_lies_beside_what_is_near_and_is_as_wide_as_the_baseline_says():
    reach = EYE.fx * 0.075
    dark = shadowed(step_edge().astype(np.float32), reach)
    assert not dark[:80].any() and not dark[160:].any()
    columns = np.flatnonzero(dark[120])
    assert columns.max() == 119
    assert len(columns) == pytest.approx(reach * (1 / 0.6 - 1 / 0.9), abs=2)


def test_edges_fray_by_nguyens_lateral_deviation():
    sensor = Sensor(angled=False, step=0, baseline=0, flying=0, grazing=(90, 91), dark=0, glare=2, holes=0)
    depth = step_edge()
    near = np.mean([read(depth, sensor, seed)[90:150] < 0.75 for seed in range(30)], axis=(0, 1))
    assert near[110] == 0 and near[130] == 1
    offsets = np.arange(111, 130) - 119.5
    density = np.diff(near[110:130])
    deviation = np.sqrt(np.sum(density * (offsets - np.sum(density * offsets)) ** 2))
    assert deviation == pytest.approx(0.5 * 0.8, abs=0.25)  # half of the pixels at 640×480


def test_flying_pixels_lie_between_and_only_at_edges():
    sensor = Sensor(angled=False, lateral=0, step=0, baseline=0, grazing=(90, 91), dark=0, glare=2, holes=0)
    flying = read(step_edge(), sensor)
    between = (flying > 0.62) & (flying < 0.88)
    assert 20 < between.sum() < 200
    assert not between[82:158, 122:198].any() and not between[:78].any()


def test_dark_blinding_and_grazing_surfaces_give_no_reading():
    colour = GREY.copy()
    colour[:, :100], colour[:, 200:] = 5, 255
    seen = read(np.full((240, 320), 0.8), Sensor(holes=0), colour=colour) > 0
    assert not seen[:, :100].any() and not seen[:, 200:].any() and seen[:, 110:190].all()
    share = [(read(tilted(d), Sensor(holes=0, baseline=0))[118:122] > 0).mean() for d in (60, 76, 81)]
    assert share[0] == 1 and 1 > share[1] > share[2] > 0


def test_axial_alone_has_no_holes_within_its_range_and_every_seed_its_own_noise():
    depth = step_edge()
    assert (read(depth, AXIAL) > 0).all()
    np.testing.assert_array_equal(read(depth, KINECT, 3), read(depth, KINECT, 3))
    assert (read(depth, KINECT, 3) != read(depth, KINECT, 4)).mean() > 0.5
    assert (read(np.full((240, 320), 0.3), KINECT) == 0).all()


def test_intrinsics_keep_the_field_of_view():
    small, large = kinect_intrinsics(160, 120), kinect_intrinsics(640, 480)
    assert small.width / small.fx == large.width / large.fx
    assert isinstance(small, Intrinsics)
