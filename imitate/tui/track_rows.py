"""Of the hand and each object: how sure the tracker is of it, and when in the recording it was seen."""

from __future__ import annotations

from textual.content import Content

from imitate.tui.overlay import PAPER
from imitate.tui.sighting import Sighting
from imitate.tui.words import bar

HEIGHTS = "▁▂▃▄▅▆▇"
"""the highest leaves a gap to the row above."""
LOST, COMING = "✗", "·"
BAR = 8
NOW = BAR + 8
"""cells of a bar, and of it with its number."""
NAME = 12
"""letters of a name, at most."""


def track_rows(sighting: Sighting, frame: int, width: int, left_out: frozenset[str] = frozenset()) -> Content:
    """A line for each body, one above and, with the time of ``frame``, one below.

    Args:
        width: cells.
        left_out: bodies that could not be followed, and are in no demonstration.
    """
    names = [name[:NAME] for name in sighting.cast.names]
    longest = max(map(len, names))
    before = 3 + longest + 1 + NOW
    strip = max(width - before - 10, 4)
    head = f"{'':{3 + longest}} {'confidence':<{NOW}}{'seen':<{strip}}{'lost':>10}"
    lines = [Content.styled(head[:width], "$text-muted")]
    for body, name in enumerate(names):
        red, green, blue = sighting.cast.inks[body]
        swatch = Content.styled(" ■ ", f"rgb({red},{green},{blue}) on {PAPER}")
        lost = f"{sighting.lost_seconds[body]:.2f} s"
        total = "left out" if sighting.cast.names[body] in left_out else lost
        lines.append(
            Content("").join(
                [
                    swatch,
                    Content(f"{name:<{longest}} "),
                    _now(sighting, frame, body),
                    _strip(sighting, body, strip),
                    Content.styled(f"{total:>10}", "$text-error" if sighting.lost[:, body].any() else ""),
                ]
            )
        )
    return Content("\n").join([*lines, _mark(sighting, frame, before, strip)])


def signs(sighting: Sighting, body: int, width: int) -> str:
    """A sign for each of ``width`` stretches of the recording: ✗ where the body was lost in any frame.

    Else a block as high as the least confidence; · where it is not tracked yet.
    """
    found = []
    lost, confidence = sighting.lost[:, body], sighting.confidence[:, body]
    for column in range(width):
        first = column * sighting.count // width
        frames = slice(first, max((column + 1) * sighting.count // width, first + 1))
        if not len(lost[frames]):
            found.append(COMING)
        elif lost[frames].any():
            found.append(LOST)
        else:
            found.append(HEIGHTS[min(int(confidence[frames].min() * len(HEIGHTS)), len(HEIGHTS) - 1)])
    return "".join(found)


def _now(sighting: Sighting, frame: int, body: int) -> Content:
    if sighting.lost[frame, body]:
        return Content.styled(f"{LOST} lost".ljust(NOW), "bold $text-error")
    sure = float(sighting.confidence[frame, body])
    return Content(f"{bar(sure, BAR)} {100 * sure:3.0f} %".ljust(NOW))


def _strip(sighting: Sighting, body: int, width: int) -> Content:
    parts = [
        Content.styled(sign, {LOST: "bold $text-error", COMING: "$text-disabled"}.get(sign, "$text-success"))
        for sign in signs(sighting, body, width)
    ]
    return Content("").join(parts)


def _mark(sighting: Sighting, frame: int, before: int, width: int) -> Content:
    column = before + min(frame * width // max(sighting.count, 1), width - 1)
    label = f"{sighting.t[frame] - sighting.t[0]:.2f} s"
    if column + len(label) + 2 > before + width:
        return Content(f"{label} ▲".rjust(column + 1))
    return Content(" " * column + f"▲ {label}")
