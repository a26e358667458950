"""Pinhole cameras."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from imitate.rgbd import Intrinsics


@given(
    st.tuples(st.integers(2, 40), st.integers(2, 40)),
    st.tuples(st.floats(20, 900), st.floats(20, 900), st.floats(0, 40), st.floats(0, 40)),
    st.floats(0.05, 10),
)
def test_a_point_is_seen_in_the_pixel_whose_ray_it_lies_on(size, lens, depth):
    camera = Intrinsics(*size, *lens)
    pixels = camera.project(camera.rays().reshape(-1, 3) * depth)
    v, u = np.mgrid[: size[1], : size[0]]
    np.testing.assert_allclose(pixels, np.stack([u.ravel(), v.ravel()], axis=1), atol=1e-6)


def test_what_is_not_in_front_of_the_camera_is_not_seen():
    camera = Intrinsics(8, 6, 9, 9, 4, 3)
    pixels = camera.project(np.array([[0, 0, 0.0], [0.1, 0, -1], [0, 0, np.nan], [0, 0, 1]]))
    assert np.isnan(pixels).all(axis=1).tolist() == [True, True, True, False]
