"""Pictures of recordings, as well as the terminal can show them: Sixel, Kitty's protocol, or half blocks."""

from __future__ import annotations

import logging
from collections.abc import Callable
from logging.handlers import BufferingHandler
from typing import Any

from textual.widget import Widget

Photo = Callable[[], Widget]
"""makes a widget whose ``image`` is a PIL picture, or None."""


def photo_of_terminal(tell: Callable[[str], None] = lambda _: None) -> Photo | None:
    """What this terminal draws pictures with; None where there is no way to.

    Called before the application runs: when it is imported, the library asks the terminal what it can do,
    and Textual owns the terminal by then. On one that does not say how large it is, that fails, or it logs
    why it guesses; with no handler that would be a traceback on the screen.

    Args:
        tell: hears why pictures are not as good as they could be.
    """
    complaints = BufferingHandler(capacity=100)
    logging.getLogger("textual_image").addHandler(complaints)
    try:
        from textual_image import renderable, widget
    except Exception as error:
        tell(f"no pictures are shown, as this terminal does not say how it draws them ({error})")
        return None
    if complaints.buffer:
        tell("pictures are of half blocks, as this terminal does not say how large a character is in pixels")
        return _maker(widget.HalfcellImage)
    asked = renderable.Image is not renderable.UnicodeImage  # that is taken where there is no terminal
    return _maker(widget.Image if asked else widget.HalfcellImage)


def _maker(kind: Any) -> Photo:
    def make() -> Widget:
        made: Widget = kind(id="photo")
        return made

    return make
