"""The scene of a trial, or of a demonstration, from above and from the side: table, objects, gripper, arm."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array, rotate
from imitate.record import SceneSpec
from imitate.tui.drawing import Drawing
from imitate.tui.film import Film
from imitate.tui.timeline import BANDS

Side = Literal["top", "side"]
AXES: dict[Side, tuple[int, int]] = {"top": (0, 1), "side": (0, 2)}
"""what goes to the right and up, of x y z."""
MARGIN = 0.05
"""m around what was shown."""
FINGER = 0.06
"""m, length of the fingers as drawn."""
OPENED, CLOSED = 0.04, 0.02
"""m from the hand's middle to a finger, as drawn."""
_CORNERS = np.array([[(k >> axis & 1) - 0.5 for axis in range(3)] for k in range(8)])


@dataclass(frozen=True)
class Stage:
    """What stays the same in all films of a session.

    Attributes:
        names, sizes: of the K objects, metres.
        low, high: (3,) corners of the space that is shown.
    """

    names: tuple[str, ...]
    sizes: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, scene: SceneSpec, demonstration: Demonstration) -> Stage:
        """The space in which the hand and the objects were shown, with the scene's objects."""
        return replace(cls.showing(demonstration), names=scene.object_names, sizes=scene.object_sizes)

    @classmethod
    def showing(cls, demonstration: Demonstration) -> Stage:
        """The space in which the hand and the objects were shown."""
        bodies = [demonstration.hand[:, None], demonstration.objects]
        points = np.concatenate([b[..., :3].reshape(-1, 3) for b in bodies])
        low, high = np.nanmin(points, axis=0) - MARGIN, np.nanmax(points, axis=0) + MARGIN
        low[2] = -0.02
        return cls(demonstration.object_names, demonstration.object_sizes, low, high)


class SceneView(Drawing):
    """One moment of a film, in lines of braille dots."""

    def __init__(self, side: Side) -> None:
        super().__init__(id=side)
        self._side = side
        self._shown: tuple[Stage, Film, int] | None = None

    def show(self, shown: tuple[Stage, Film, int] | None) -> None:
        """Draw a moment; nothing without one."""
        self._shown = shown
        self.redraw()

    def draw(self) -> None:
        """Which axes are shown, and the moment."""
        right, up = AXES[self._side]
        self.dots.words(f"{self._side}  {'xyz'[right]} → {'xyz'[up]} ↑", 0, 0, self.ink("text-muted"))
        if self._shown:
            self._draw_moment(*self._shown)

    def _draw_moment(self, stage: Stage, film: Film, k: int) -> None:
        k = min(max(k, 0), film.last)
        if self._side == "side":
            flat = np.array([[stage.low[0] - 1, 0, 0], [stage.high[0] + 1, 0, 0]])
            self._line(stage, flat, "text-disabled")
        if film.arm.shape[1]:
            self._line(stage, film.arm[k].astype(float), "text-muted")
        for n in range(len(stage.names)):
            self._object(stage, film.objects[k, n].astype(float), n)
        for part in gripper(film.hand[k].astype(float), float(film.force[k])):
            self._line(stage, part, "foreground")
        if not film.arm.shape[1]:
            (wrist,) = self._cells(stage, gripper(film.hand[k].astype(float), 0.0)[1][1:])
            self.dots.words("hand", round(wrist[0]) + 1, round(wrist[1]), self.ink("foreground"))

    def _object(self, stage: Stage, pose: Array, n: int) -> None:
        colour = BANDS[n % len(BANDS)]
        size = np.nan_to_num(stage.sizes[n], nan=0.03)
        corners = pose[:3] + rotate(pose[3:], _CORNERS * size)
        axes = list(AXES[self._side])
        ring = cv2.convexHull(corners[:, axes].astype(np.float32))[:, 0].astype(float)
        points = np.zeros((len(ring) + 1, 3))
        points[:, axes] = np.vstack([ring, ring[:1]])
        self._line(stage, points, colour)
        middle = self._cells(stage, pose[None])[0, 0]
        top = self._cells(stage, corners)[:, 1].min()
        name = stage.names[n]
        self.dots.words(name, round(middle - len(name) / 2), int(np.floor(top)) - 1, self.ink(colour))

    def _line(self, stage: Stage, points: Array, colour: str) -> None:
        self.dots.line(self._cells(stage, points), self.ink(colour))

    def _cells(self, stage: Stage, points: Array) -> Array:
        # (N, 2) columns and rows; a cell is twice as high as wide, and both axes have the same scale.
        axes, size = list(AXES[self._side]), self.size
        room = np.array([size.width, 2 * max(size.height - 1, 1)], float)
        span = (stage.high - stage.low)[axes]
        scale = float((span / room).max())
        middle = (stage.high + stage.low)[axes] / 2
        x, y = ((points[:, axes] - middle) / scale).T
        return np.stack([size.width / 2 + x, 1 + (size.height - 1) / 2 - y / 2], axis=1)


def gripper(hand: Array, force: float) -> list[Array]:
    """Lines (N, 3) of palm and fingers at a pose (7,) of the tool-centre point; closed under a force (N)."""
    apart = CLOSED if force > 0 else OPENED
    fingers = np.array([[0, -apart, 0], [0, -apart, -FINGER], [0, apart, -FINGER], [0, apart, 0]])
    wrist = np.array([[0, 0, -FINGER], [0, 0, -1.5 * FINGER]])
    return [hand[:3] + rotate(hand[3:], part) for part in (fingers, wrist)]
