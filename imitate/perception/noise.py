"""How far a depth camera's readings scatter, by range."""

from __future__ import annotations

import numpy as np

from imitate.geometry import Array

BEST, WORST = 0.25, 4.0
"""a sensor's scatter, as multiples of a Kinect's: what is found outside is not believed."""


def kinect_noise(depth: Array) -> Array:
    """Standard deviation in metres of a Kinect's reading at ``depth`` metres (Nguyen et al. 2012, axial)."""
    return np.asarray(0.0012 + 0.0019 * (np.asarray(depth) - 0.4) ** 2)


def scatter(residuals: Array, depth: Array) -> float:
    """A sensor's noise as a multiple of a Kinect's, from residuals (N,) of readings at depths (N,).

    From the median, so that up to half of the residuals may belong to something else.
    """
    found = 1.4826 * float(np.median(np.abs(residuals) / kinect_noise(depth)))
    return float(np.clip(found, BEST, WORST))
