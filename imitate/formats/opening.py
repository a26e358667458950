"""How the hand's opening is called in people's files."""

from __future__ import annotations

import re

import numpy as np

from imitate.geometry import Array

OPENING = "opening"
_OTHERS = {
    f"{hand}_{what}" for hand in ("hand", "gripper", "fingers") for what in ("opening", "width", "distance")
}
WIDEST = 0.5
"""m; what is said to be wider is a share or a percentage, as other programs have it."""


def is_opening(name: str) -> bool:
    """Whether a column or a topic's end is called as the opening usually is."""
    plain = re.sub(r"[./ -]", "_", name.strip("/").lower())
    return plain == OPENING or plain in _OTHERS


def in_metres(name: str, values: Array) -> bool:
    """Whether numbers found by their name alone are an opening (T,) in metres; our own are."""
    seen = values[~np.isnan(values)]
    return name == OPENING or bool(np.all((seen >= 0) & (seen <= WIDEST)))
