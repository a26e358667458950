"""Synthetic stacking demonstrations with known skills, for segmentation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array, from_yaw
from imitate.skill import Abstraction, Segment

EDGE = 0.05
NAMES = ("blue", "green", "red", "yellow", "white", "black")
RIGHT = (
    Abstraction(("hand",), "blue"),
    Abstraction(("hand", "blue"), "green"),
    Abstraction(("hand",), "blue"),
)


@dataclass(frozen=True)
class Stacking:
    """What varies. Seconds, metres, frames/s; ``noise`` is per axis, ``drift`` a slow walk of each object."""

    objects: int = 2
    noise: float = 0.0
    rest: float = 0.0
    pause: float = 0.0
    mid_pause: float = 0.0
    speed: float = 1.0
    rate: float = 30.0
    drift: float = 0.0
    near: float | None = None
    """how far from a distractor the hand rests before it starts; None: 25 cm above the table."""


def perform(what: Stacking, rng: np.random.Generator) -> tuple[Demonstration, tuple[float, float]]:
    """The blue block is put on the green one; also the times at which it starts and stops to be carried."""
    blocks = _apart(what.objects, rng)
    blue, green = blocks[0], blocks[1]
    home = np.array([rng.uniform(-0.3, 0.3), -0.35, 0.25])
    if what.near is not None:
        side = rng.normal(size=2)
        home = blocks[-1] + np.array([*(side / np.linalg.norm(side) * what.near), 0])
    goal, up = green + np.array([0, 0, EDGE]), np.array([0, 0, 0.12])
    away = home + np.array([0, 0, 0.1])
    waypoints = [
        (0.0, home),
        (what.rest, home),
        (1.2 / what.speed, blue + up),
        (0.8 / what.speed, blue),
        (what.pause, blue),
        (0.7 / what.speed, blue + up),
        (what.mid_pause, blue + up),
        (1.0 / what.speed, goal + up),
        (0.7 / what.speed, goal),
        (what.pause, goal),
        (0.8 / what.speed, goal + up),
        (1.0 / what.speed, away),
        (what.rest, away),
    ]
    ends = np.cumsum([duration for duration, _ in waypoints])
    t = np.arange(0, ends[-1] + 1e-9, 1 / what.rate)
    hand = _minimum_jerk(t, ends, [point for _, point in waypoints])
    lift, place = ends[4], ends[8]
    objects = np.repeat(blocks[None], len(t), axis=0)
    carried = (t >= lift) & (t <= place)
    objects[carried, 0] = hand[carried]
    objects[t > place, 0] = goal
    walk = np.sin(2 * np.pi * (t[:, None, None] / 15 + rng.uniform(size=(1, what.objects, 3))))
    objects = objects + what.drift / 2 * walk
    yaw = np.repeat(rng.uniform(-np.pi, np.pi, (1, what.objects)), len(t), axis=0)
    noisy = [x + rng.normal(scale=what.noise, size=x.shape) if what.noise else x for x in (hand, objects)]
    demonstration = Demonstration(
        t=t,
        hand=from_yaw(noisy[0], np.zeros(len(t))),
        objects=from_yaw(noisy[1], yaw),
        object_names=NAMES[: what.objects],
        object_sizes=np.full((what.objects, 3), EDGE),
    )
    return demonstration, (float(lift), float(place))


def is_right(segments: Sequence[Segment], times: tuple[float, float], tolerance: float) -> bool:
    """Whether the three skills were found, and cut where carrying starts and stops."""
    found = tuple(s.abstraction for s in segments)
    return found == RIGHT and bool(
        np.all(np.abs(np.subtract([segments[1].start, segments[1].end], times)) <= tolerance)
    )


def _minimum_jerk(t: Array, ends: Array, points: Sequence[Array]) -> Array:
    k = np.clip(np.searchsorted(ends, t, side="left"), 1, len(ends) - 1)
    u = np.clip((t - ends[k - 1]) / np.maximum(ends[k] - ends[k - 1], 1e-9), 0, 1)[:, None]
    a, b = np.array(points)[k - 1], np.array(points)[k]
    return np.asarray(a + (b - a) * (10 * u**3 - 15 * u**4 + 6 * u**5))


def _apart(count: int, rng: np.random.Generator) -> Array:
    while True:
        found = np.column_stack([rng.uniform(-0.3, 0.3, (count, 2)), np.full(count, EDGE / 2)])
        distances = np.linalg.norm(found[:, None] - found[None], axis=-1) + np.eye(count)
        if distances.min() > 0.12:
            return found
