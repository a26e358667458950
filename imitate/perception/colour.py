"""Colours by hue: which pixels are coloured at all, and what a hue is called."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.errors import UnknownNameError

HUES = {
    "red": (345, 15),
    "orange": (15, 42),
    "yellow": (42, 70),
    "green": (70, 165),
    "cyan": (165, 195),
    "blue": (195, 255),
    "purple": (255, 320),
    "pink": (320, 345),
}
"""name → degrees, from (inclusive) to (exclusive), around the circle."""
FINGERS = {"left finger": -1.0, "right finger": -2.0}
"""what stands for a hue where a pixel shows a finger, whatever colour that has."""
SATURATION, VALUE = 0.45, 0.12
"""0…1, from which a pixel counts as coloured."""


def hues(colour: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(H, W) degrees 0…360 of an (H, W, 3) picture; NaN where it is grey or black."""
    hsv = cv2.cvtColor(np.ascontiguousarray(colour), cv2.COLOR_RGB2HSV_FULL)
    found = hsv[..., 0].astype(np.float32) * np.float32(360 / 256)
    found[(hsv[..., 1] < 255 * SATURATION) | (hsv[..., 2] < 255 * VALUE)] = np.nan
    return found


def is_hue(degrees: NDArray[np.float32], name: str) -> NDArray[np.bool_]:
    """Where a hue has this name, or shows this finger; nowhere where it is NaN.

    Raises:
        UnknownNameError: no hue of that name.
    """
    if name in FINGERS:
        return np.asarray(degrees == FINGERS[name])
    if name not in HUES:
        raise UnknownNameError("hue", name, HUES)
    low, high = HUES[name]
    if low > high:
        return np.asarray((degrees >= low) | ((degrees >= 0) & (degrees < high)))
    return np.asarray((degrees >= low) & (degrees < high))


def dominant_hue(degrees: NDArray[np.float32]) -> str:
    """The name of most of these hues; "grey" where most are none, or a finger's."""
    counts = {name: int(is_hue(degrees, name).sum()) for name in HUES}
    best = max(counts, key=lambda name: counts[name])
    none = int(np.isnan(degrees).sum() + (degrees < 0).sum())
    return best if counts[best] * 2 > len(degrees) or counts[best] > none else "grey"
