"""The two fingers' colours in a picture, and which points of a view are fingers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imitate.errors import UsageError
from imitate.geometry import Array
from imitate.perception.clusters import dense_parts
from imitate.perception.colour import FINGERS, hues
from imitate.perception.paint import FEWEST, Paint, Picture, full_hsv, resolve, turn
from imitate.perception.shapes import Mask
from imitate.settings import Perception

LEFT, RIGHT = -1, 1
"""along the hand's y."""
BRIGHT = 0.75
"""0…1, from which an unsaturated pixel within a finger is a highlight."""
FILL = 7
"""pixels, the widest highlight across a finger."""
ALIKE = 8.0
"""degrees of hue between the fingers, below which they cannot be told apart."""


@dataclass(frozen=True)
class FingerColours:
    """What the two fingers look like, resolved once for a recording."""

    left: Paint
    right: Paint

    def sides(self, colour: Picture) -> NDArray[np.int8]:
        """(H, W) of an (H, W, 3) picture: −1 where the left finger's colour is, 1 the right one's, else 0.

        White spots that a finger's colour surrounds are its highlights, and its own.
        """
        hsv = full_hsv(colour)
        found = np.zeros(colour.shape[:2], np.int8)
        for side, paint in ((LEFT, self.left), (RIGHT, self.right)):
            mask = paint.covers(hsv)
            if min(mask.shape) >= FILL and mask.any():
                closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((FILL, FILL), np.uint8)) > 0
                mask[closed & (hsv[..., 1] < 255 * paint.saturation) & (hsv[..., 2] > 255 * BRIGHT)] = 255
            found[mask > 0] = side
        return found

    def hues(self, colour: Picture) -> NDArray[np.float32]:
        """(H, W) hues as of `colour.hues`, with the fingers' pixels marked as `FINGERS`."""
        found, sides = hues(colour), self.sides(colour)
        found[sides == LEFT] = FINGERS["left finger"]
        found[sides == RIGHT] = FINGERS["right finger"]
        return found


def finger_colours(settings: Perception, colour: Picture | None = None) -> FingerColours:
    """The fingers' colours as the settings say: "red", "#c81e1e", or "U,V", a pixel of the first picture.

    Of a colour or pixel, the thresholds come from the picture: from the scatter of the patch that is meant,
    and from the nearest colours and saturations beside it.

    Args:
        settings: ``left_finger`` and ``right_finger`` count.
        colour: (H, W, 3), the first picture; None where there is none in rows.

    Raises:
        UsageError: not a colour, a pixel that is grey or outside the picture, a colour that is not in it,
            or two that are too alike.
    """
    left = resolve("left_finger", settings.left_finger, colour)
    right = resolve("right_finger", settings.right_finger, colour)
    return _apart(left, right)


def worn(points: Array, sides: NDArray[np.int8], settings: Perception, noise: float) -> Mask:
    """(N,) which points (N, 3) belong to the fingers, or touch one, of those that have a finger's colour.

    A finger is as thin and as short as the cylinder worn on it, and stands alone: a coloured patch within
    something else is not one.

    Args:
        points: of a view, metres.
        sides: (N,) as from `FingerColours.sides`.
        settings: radius and length of the cylinders.
        noise: standard deviation of the points, metres.
    """
    belongs = np.zeros(len(points), bool)
    coloured = np.flatnonzero(sides)
    if not len(coloured):
        return belongs
    for side in (LEFT, RIGHT):
        own = np.flatnonzero(sides == side)
        for part in dense_parts(points[own], settings.finger_radius, 5) if len(own) else []:
            piece = own[part]
            if len(piece) < FEWEST or not is_finger(points[piece], settings, noise):
                continue
            reach = 1.5 * settings.finger_radius
            low, high = points[piece].min(axis=0) - reach, points[piece].max(axis=0) + reach
            around = np.flatnonzero(np.all((points > low) & (points < high), axis=1) & (sides == 0))
            away, _ = cKDTree(points[piece]).query(points[around], distance_upper_bound=reach)
            if np.isfinite(away).sum() < len(piece):
                belongs[piece] = True
                belongs[around[away < settings.finger_radius / 2]] = True
    return belongs


def is_finger(points: Array, settings: Perception, noise: float) -> bool:
    """Whether points (N, 3) are as short and thin as a finger's cylinder, but for their noise in metres."""
    middle = np.median(points, axis=0)
    axes = np.linalg.svd((points - middle).T @ (points - middle))[0]
    along = (points - middle) @ axes
    length, width, _ = np.percentile(along, 98, axis=0) - np.percentile(along, 2, axis=0)
    slack = 4 * noise
    return bool(
        length < 1.2 * settings.finger_length + slack and width < 2.4 * settings.finger_radius + slack
    )


def _apart(left: Paint, right: Paint) -> FingerColours:
    """Both, with hues that overlap cut half-way between them."""
    gap = turn(right.middle, left.middle)
    if abs(gap) < ALIKE:
        raise UsageError(
            f"settings: perception.left_finger and right_finger are hues of {left.middle:.0f}° and "
            f"{right.middle:.0f}°: too alike to tell left from right. Wear two colours that differ by "
            f"{ALIKE:.0f}° or more."
        )
    if (left.width + right.width) / 2 <= abs(gap):
        return FingerColours(left, right)
    cut = (left.middle + gap / 2) % 360
    if gap > 0:
        return FingerColours(replace(left, high=cut), replace(right, low=cut))
    return FingerColours(replace(left, low=cut), replace(right, high=cut))
