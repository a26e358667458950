"""Where on the table a block that was lost may be."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from imitate.geometry import Array
from imitate.perception.evidence import Body, evidence_for
from imitate.perception.eye import View

COARSE = 4
"""pixels between those that are searched over the whole picture."""
PLACES = 3
"""that are tried."""
SMALLEST = 3
"""pixels of the coarse picture that a place must show."""
YAWS: Array = np.pad(np.arange(4)[:, None] * np.pi / 4, ((0, 0), (5, 0)))
"""(4, 6) turns that are tried at each place: a box looks the same after half a turn."""
YAWS.flags.writeable = False


def patches(view: View, hue: str | None, others: Sequence[Body], noise: float) -> list[Array]:
    """Middles (3,) of the largest connected patches over the table that could show a body of this hue."""
    window = (slice(0, None, COARSE), slice(0, None, COARSE))
    pixels = view.pixels(window)
    evidence = evidence_for(hue, pixels, others, noise)
    own = np.zeros(len(pixels.depth), np.uint8)
    own[evidence.order[: evidence.edges[0]]] = 1
    points = pixels.points()
    own[~view.eye.is_over_table(points)] = 0
    _, labels, stats, _ = cv2.connectedComponentsWithStats(own.reshape(view.frame.depth[window].shape))
    areas = stats[1:, cv2.CC_STAT_AREA]
    largest = [k for k in np.argsort(-areas, kind="stable")[:PLACES] if areas[k] >= SMALLEST]
    return [np.median(points[labels.reshape(-1) == 1 + k], axis=0) for k in largest]
