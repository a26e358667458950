"""Depths in metres, and whether they can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.pictures import Pixels

NEAR, FAR = 0.1, 15.0
"""m between which the middle reading of a camera above a table lies, whatever the camera; generously."""
UNIT_OPTION = (
    "Pass the metres of one step: --depth-unit 0.001 for millimetres, 0.0002 for 5000 steps a metre, 1 for "
    "metres."
)


def to_metres(pixels: Pixels, unit: float) -> NDArray[np.float32]:
    """Depth pixels times ``unit``; 0 where there is no reading."""
    with np.errstate(invalid="ignore", over="ignore"):
        metres = pixels.astype(np.float32) * np.float32(unit)
    if pixels.dtype.kind == "f":
        metres[~(np.isfinite(metres) & (metres > 0))] = 0
    return metres


def check_distances(path: Path, what: str, metres: NDArray[np.floating], unit: float) -> None:
    """Raises FileError when the middle of some readings (N,) can be no distance from a table.

    Args:
        path: of the recording or cloud.
        what: that holds them, in words.
        metres: N > 0 readings.
        unit: metres of one step with which they were read.
    """
    middle = float(np.median(metres))
    if not NEAR < middle < FAR:
        raise FileError(
            path,
            f"{what} holds depths in an unknown unit: at {unit:g} m a step its middle reading is "
            f"{middle:.4g} m, where a camera above a table has {NEAR:g} to {FAR:g} m",
            UNIT_OPTION,
        )
