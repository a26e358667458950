"""A demonstration at one moment: the recorded picture, and the scene from above and from the side."""

from __future__ import annotations

import numpy as np
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.geometry import Size

from imitate.demonstration import Demonstration, interpolated
from imitate.tui.album import Album, Shot, opened
from imitate.tui.film import Film, film_shown
from imitate.tui.picture import Blocks, fitting
from imitate.tui.scene_view import SceneView, Stage


class Moment(Horizontal):
    """Shows one frame; where there is no picture, the scene has the room."""

    def __init__(self) -> None:
        super().__init__(id="moment")
        self._of: Demonstration | None = None
        self._seen: tuple[Stage, Film] | None = None
        self._shot: Shot | None = None

    def compose(self) -> ComposeResult:
        """The picture and both views."""
        yield Blocks(id="picture")
        yield SceneView("top")
        yield SceneView("side")

    def show(self, demonstration: Demonstration, frame: int, album: Album) -> None:
        """Show this frame of the demonstration, with the picture nearest in time."""
        if demonstration is not self._of:
            whole = interpolated(demonstration)
            self._of, self._seen = demonstration, (Stage.showing(whole), film_shown(whole))
        assert self._seen is not None
        for view in self.query(SceneView):
            view.show((*self._seen, frame))
        shot = album.nearest(float(demonstration.t[frame] - demonstration.t[0]))
        picture = self.query_one(Blocks)
        picture.display = shot is not None
        if shot is not None and shot is not self._shot:
            picture.show(opened(shot))
        self._shot = shot
        self.on_resize()

    def on_resize(self) -> None:
        """The picture as wide as its height wants, and at most half of the room."""
        picture = self.query_one(Blocks)
        room = Size(self.size.width // 2, self.size.height)
        picture.styles.width = fitting(picture.image, room)[0] + 1


def unseen(demonstration: Demonstration, frame: int) -> tuple[str, ...]:
    """Bodies that were not seen in a frame, the hand first."""
    d = demonstration
    gone = np.flatnonzero(np.isnan(d.objects[frame, :, 0]))
    hand = ("hand",) if np.isnan(d.hand[frame, 0]) else ()
    return (*hand, *(d.object_names[k] for k in gone))
