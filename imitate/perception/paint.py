"""A colour to look for: named by its hue, given, or picked, with thresholds learned from the picture."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.errors import UsageError
from imitate.perception.colour import HUES, SATURATION, VALUE
from imitate.perception.shapes import Mask

Picture = NDArray[np.uint8]

NARROWEST, WIDEST = 8.0, 25.0
"""degrees of hue to either side of a picked colour that may count as it."""
FAINTEST = 0.15
"""0…1, saturation below which no colour can be picked."""
SPREAD = 4.0
"""standard deviations of the picked patch's hue that belong to it."""
FEWEST = 12
"""pixels of a picked colour."""
ALIKE = 0.04
"""0…1, how far the shares of red, green and blue in a patch's pixels may differ from the picked one's."""


@dataclass(frozen=True)
class Paint:
    """A range of colours: hue from ``low`` up to ``high`` degrees, least saturation and least value 0…1."""

    low: float
    high: float
    saturation: float = SATURATION
    value: float = VALUE

    @property
    def width(self) -> float:
        """Degrees of hue."""
        return (self.high - self.low) % 360

    @property
    def middle(self) -> float:
        """Degrees, the hue half-way."""
        return (self.low + self.width / 2) % 360

    def covers(self, hsv: Picture) -> Picture:
        """(H, W) 255 where a picture in OpenCV's full HSV has this colour, else 0."""
        s, v = int(np.ceil(255 * self.saturation)), int(np.ceil(255 * self.value))
        low, high = self.low % 360 * 256 / 360, self.high % 360 * 256 / 360
        spans = [(low, high)] if low <= high else [(low, 256.0), (0.0, high)]
        found = np.zeros(hsv.shape[:2], np.uint8)
        for a, b in spans:
            found[
                cv2.inRange(hsv, np.array([np.ceil(a), s, v]), np.array([np.ceil(b) - 1, 255, 255])) > 0
            ] = 255
        return found


def resolve(field: str, value: str, colour: Picture | None) -> Paint:
    """What a setting means: "red", "#c81e1e", or "U,V", a pixel of this picture (H, W, 3).

    Raises:
        UsageError: none of them; the message names the setting ``field`` of perception.
    """
    if value in HUES:
        return Paint(*map(float, HUES[value]))
    where = f"settings: perception.{field} = {value!r}"
    pixel = re.fullmatch(r"\s*(\d+)\s*,\s*(\d+)\s*", value)
    if pixel:
        if colour is None:
            raise UsageError(f"{where} is a pixel, and there is no picture to look it up in. Name a hue.")
        return _at_pixel(int(pixel[1]), int(pixel[2]), colour, where)
    if re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        rgb = np.array([int(value[k : k + 2], 16) for k in (1, 3, 5)], np.uint8)
        return _like(rgb, colour, where)
    raise UsageError(
        f"{where}: not a colour. Valid: a hue ({', '.join(HUES)}), a colour as '#c81e1e', or a pixel of the "
        "first picture as 'U,V', counted from its upper left corner."
    )


def _at_pixel(u: int, v: int, colour: Picture, where: str) -> Paint:
    height, width = colour.shape[:2]
    if u >= width or v >= height:
        raise UsageError(f"{where}: outside of the picture, which is {width} wide and {height} high.")
    smooth = cv2.medianBlur(np.ascontiguousarray(colour), 3).astype(np.float32)
    meant = smooth[v, u].astype(np.uint8)
    # The shares of red, green and blue do not change with the shade.
    shares = smooth / np.maximum(smooth.sum(axis=2, keepdims=True), 1)
    filled = np.zeros((height + 2, width + 2), np.uint8)
    flags = 4 | cv2.FLOODFILL_MASK_ONLY | cv2.FLOODFILL_FIXED_RANGE
    cv2.floodFill(shares, filled, (u, v), 0, (ALIKE,) * 3, (ALIKE,) * 3, flags)
    return _learned(meant, colour, filled[1:-1, 1:-1] > 0, where)


def _like(meant: Picture, colour: Picture | None, where: str) -> Paint:
    hue, saturation, value = _hsv(meant[None, None])[0, 0]
    _refuse_grey(saturation, meant, where)
    wide = Paint(hue - WIDEST, hue + WIDEST, max(FAINTEST, saturation / 2), value / 3)
    if colour is None:
        return wide
    patch = wide.covers(full_hsv(colour)) > 0
    if patch.sum() < FEWEST:
        raise UsageError(f"{where}: nothing in the first picture is near that colour.")
    return _learned(meant, colour, patch, where)


def _learned(meant: Picture, colour: Picture, patch: Mask, where: str) -> Paint:
    """The range that holds a patch (H, W) and as little else of the picture as can be."""
    hsv = _hsv(colour)
    beyond = cv2.dilate(patch.astype(np.uint8), np.ones((9, 9), np.uint8)) == 0  # its edges are mixtures
    own, rest = hsv[patch], hsv[beyond]
    _refuse_grey(float(np.median(own[:, 1])), meant, where)
    own = own[own[:, 1] > FAINTEST]
    weights = own[:, 1] * np.exp(1j * np.deg2rad(own[:, 0]))
    middle = float(np.rad2deg(np.angle(weights.sum())))
    spread = max(1.4826 * float(np.median(np.abs(turn(own[:, 0], middle)))), 1.5)
    away = np.abs(turn(rest[:, 0], middle))
    least = float(np.percentile(own[:, 1], 5))
    beside = rest[away < WIDEST, 1]
    rival = float(np.percentile(beside, 99)) if len(beside) > FEWEST else 0.0
    saturation = max((least + rival) / 2 if rival < least else least, least / 2, FAINTEST / 2)
    value = float(np.percentile(own[:, 2], 5)) / 2
    strong = (rest[:, 1] > saturation) & (rest[:, 2] > value)
    rivals = away[strong & (away > SPREAD * spread) & (away < 2 * WIDEST)]
    half = float(np.clip(SPREAD * spread, NARROWEST, WIDEST))
    if len(rivals) > FEWEST:
        half = min(half, (SPREAD * spread + float(np.percentile(rivals, 5))) / 2)
    return Paint((middle - half) % 360, (middle + half) % 360, saturation, value)


def turn(degrees: Any, middle: float) -> Any:
    """Degrees from ``middle`` to these hues, −180…180."""
    return (degrees - middle + 180) % 360 - 180


def full_hsv(colour: Picture) -> Picture:
    """(H, W, 3) of a picture in OpenCV's full HSV: hue 0…255 for the circle."""
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(colour), cv2.COLOR_RGB2HSV_FULL), np.uint8)


def _hsv(colour: Picture) -> NDArray[np.float32]:
    """(H, W, 3) hue in degrees, saturation and value 0…1."""
    scale = np.array([360 / 256, 1 / 255, 1 / 255], np.float32)
    return np.asarray(full_hsv(colour) * scale, np.float32)


def _refuse_grey(saturation: float, meant: Picture, where: str) -> None:
    if saturation < FAINTEST:
        shown = "#" + "".join(f"{c:02x}" for c in meant)
        raise UsageError(
            f"{where}: {shown} is grey. Point at the finger's coloured part, not at a highlight."
        )
