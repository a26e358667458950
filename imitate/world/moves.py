"""The virtual hand's movements among objects, put together one after the other.

Movements between rests are of least jerk (Flash & Hogan 1985), as a person's are.
"""

from __future__ import annotations

import numpy as np

from imitate.demonstration import HAND, Demonstration
from imitate.geometry import Array, align_signs, compose, inverse, relative, resample
from imitate.skill import Abstraction, Segment
from imitate.world.performance import Performance, minimum_jerk

STEP = 0.01
"""s between the poses of a performance."""
SPEED = (0.16, 0.26)
"""m/s, mean of a movement: a person who shows something."""
PAUSE = (0.25, 0.45)
"""s that the hand rests while its fingers close or open."""
VERTICAL = 0.15
"""share of a movement in which the hand rises from an object, or comes down on one, without going across."""


class Moves:
    """A performance in the making: what hand and objects do from time 0, one pose every `STEP`."""

    def __init__(
        self,
        names: tuple[str, ...],
        sizes: Array,
        starts: Array,
        hand: Array,
        opening: float,
        generator: np.random.Generator,
    ) -> None:
        self.names, self.sizes = names, sizes
        self._generator = generator
        self._hand: list[Array] = [np.array(hand)]
        self._objects: list[Array] = [np.array(starts)]
        self._opening = [opening]
        self._held: tuple[int, Array] | None = None
        self._segments: list[Segment] = []
        self.rest(0.5)

    def rest(self, seconds: float) -> None:
        """The hand stays where it is."""
        steps = round(seconds / STEP)
        self._follow(np.tile(self._hand[-1], (steps, 1)), np.full(steps, self._opening[-1]))

    def go(self, pose: Array, rise: float = 0.0, up: float = VERTICAL, down: float = VERTICAL) -> None:
        """To ``pose`` (7,), rising by ``rise`` m between; not across in the shares ``up`` and ``down``."""
        start = self._hand[-1]
        length = float(np.linalg.norm(pose[:3] - start[:3])) + 1.5 * rise
        steps = max(2, round(length / self._generator.uniform(*SPEED) / STEP))
        u = np.arange(1, steps + 1) / steps
        path = resample([0, 1], np.stack([start, pose]), minimum_jerk((u - up) / (1 - up - down)))
        path[:, 2] = start[2] + minimum_jerk(u) * (pose[2] - start[2]) + 64 * rise * (u * (1 - u)) ** 3
        self._follow(path, np.full(steps, self._opening[-1]))

    def hold(self, k: int, opening: float) -> None:
        """The fingers close to ``opening``; object ``k`` goes along from here. The reach ends."""
        self._turn_fingers(opening, Abstraction((HAND,), self.names[k]))
        self._held = k, relative(self._hand[-1], self._objects[-1][k])

    def let_go(self, opening: float, reference: int) -> None:
        """The fingers open to ``opening``; what was held stays. Its carry relative to ``reference`` ends."""
        assert self._held is not None
        k, _ = self._held
        self._held = None
        self._turn_fingers(opening, Abstraction((HAND, self.names[k]), self.names[reference]))

    def carry(self, pose: Array, rise: float = 0.0, up: float = VERTICAL, down: float = VERTICAL) -> None:
        """As `go`, until the object held is at ``pose`` (7,)."""
        assert self._held is not None
        _, inside = self._held
        self.go(compose(pose, inverse(inside)), rise, up, down)

    def performance(self, left: int, hollow: tuple[str, ...] = ()) -> Performance:
        """What was made; its last skill leaves the object ``left``."""
        self._cut(Abstraction((HAND,), self.names[left]), len(self._hand) - 1)
        objects = np.array(self._objects)
        signed = np.stack([align_signs(objects[:, k]) for k in range(len(self.names))], axis=1)
        t = STEP * np.arange(len(self._hand))
        d = Demonstration(np.asarray(t), align_signs(np.array(self._hand)), signed, self.names, self.sizes)
        return Performance(d, np.array(self._opening), tuple(self._segments), hollow)

    @property
    def hand(self) -> Array:
        """(7,) the hand at the moment."""
        return self._hand[-1]

    def where(self, k: int) -> Array:
        """(7,) object ``k`` at the moment."""
        return np.array(self._objects[-1][k])

    def _turn_fingers(self, opening: float, ending: Abstraction) -> None:
        """A pause in which the fingers move; in its middle a skill ends."""
        before, first = self._opening[-1], len(self._hand)
        steps = round(self._generator.uniform(*PAUSE) / STEP)
        u = minimum_jerk(1.5 * np.arange(1, steps + 1) / steps)
        self._follow(np.tile(self._hand[-1], (steps, 1)), before + u * (opening - before))
        self._cut(ending, first + steps // 2)

    def _follow(self, path: Array, openings: Array) -> None:
        for pose, opening in zip(path, openings, strict=True):
            objects = self._objects[-1].copy()
            if self._held:
                k, inside = self._held
                objects[k] = compose(pose, inside)
            self._hand.append(pose)
            self._objects.append(objects)
            self._opening.append(float(opening))

    def _cut(self, ending: Abstraction, frame: int) -> None:
        began = self._segments[-1].end if self._segments else 0.0
        self._segments.append(Segment(began, STEP * frame, ending))
