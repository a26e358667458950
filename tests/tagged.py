"""Demonstrations as fiducial tags show them: coarse, late, frozen while a hand covers them, with outliers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from showing import HOME, UP, Camera, Move, Shown, film, lifting, spread, stacking

from imitate.demonstration import Demonstration
from imitate.geometry import Array, from_yaw, normalised, quaternion_multiply, resample

BOARD = "board"
"""the table top's own tag, which never moves."""


@dataclass(frozen=True)
class Tags:
    """How tags are seen.

    Attributes:
        noise, turn_noise: of a reading, metres per axis and radians.
        hand_noise: of the arm's own sensors, metres per axis.
        every: frames from one reading to the next.
        joined: whether what lies between is interpolated, and not the last reading again.
        outliers: share of frames from which on a tag is seen elsewhere, for up to ``longest`` of them.
        away: metres.
        frozen: whether a tag repeats its last pose while it is held.
        covered: share of the time in which any tag does, for a second or so each.
        speed: of the whole demonstration.
    """

    noise: float = 0.02
    turn_noise: float = 0.05
    hand_noise: float = 0.001
    every: int = 1
    joined: bool = False
    outliers: float = 0.01
    longest: int = 4
    away: float = 0.26
    frozen: bool = True
    covered: float = 0.0
    speed: float = 1.0


def tagged(what: Shown, tags: Tags, rng: np.random.Generator) -> Demonstration:
    """A script, and the table top's tag beside its objects, as tags show them; no size is known."""
    what = replace(what, objects={**what.objects, BOARD: from_yaw([0.1, 0.15, 0.0], 0.3)})
    clean = film(what, Camera(), rng, tags.speed)
    objects = [_seen(clean.t, clean.objects[:, k], tags, rng) for k in range(len(clean.object_names))]
    hand = clean.hand.copy()
    hand[:, :3] += rng.normal(scale=tags.hand_noise, size=(len(hand), 3))
    sizes = np.full((len(objects), 3), np.nan)
    return Demonstration(clean.t, hand, np.stack(objects, axis=1), clean.object_names, sizes)


def _seen(t: Array, track: Array, tags: Tags, rng: np.random.Generator) -> Array:
    """What a tag's topic says of its track (T, 7)."""
    readings = _read(track, tags, rng)
    fresh = np.arange(len(t)) % tags.every == 0
    moving = (track[1:] != track[:-1]).any(axis=1)
    fresh[1:] &= ~(tags.frozen & moving)
    while (~fresh).mean() < tags.covered * (1 - 1 / tags.every) + tags.covered / tags.every:
        start = rng.uniform(0, t[-1])
        fresh &= ~((t > start) & (t < start + rng.uniform(0.5, 1.5)))
    fresh[0] = True
    if tags.joined:
        return resample(t[fresh], readings[fresh], t)
    return readings[np.maximum.accumulate(np.where(fresh, np.arange(len(t)), 0))]


def _read(track: Array, tags: Tags, rng: np.random.Generator) -> Array:
    seen = track.copy()
    seen[:, :3] += rng.normal(scale=tags.noise, size=(len(track), 3))
    small = np.column_stack(
        [rng.normal(scale=tags.turn_noise / 2, size=(len(track), 3)), np.ones(len(track))]
    )
    seen[:, 3:] = quaternion_multiply(small, seen[:, 3:])
    for k in np.flatnonzero(rng.uniform(size=len(track)) < tags.outliers):
        way = rng.normal(size=3)
        seen[k : k + rng.integers(1, tags.longest + 1), :3] += tags.away * way / np.linalg.norm(way)
    return normalised(seen)


def waving(rng: np.random.Generator) -> Shown:
    """Nothing carried: the hand goes to and fro over three objects, now and then down to one."""
    points = spread(3, rng)
    moves = [
        Move(
            float(rng.uniform(0.8, 1.5)),
            points[k % 3] + rng.uniform(0.2, 1) * UP + rng.normal(scale=0.02, size=3),
        )
        for k in range(7)
    ]
    objects = {
        name: from_yaw(point, 0.0) for name, point in zip(("blue", "green", "red"), points, strict=True)
    }
    return Shown(objects, (*moves, Move(1.0, HOME)), (), HOME)


def stacked(rng: np.random.Generator) -> Shown:
    """One of three objects put on another one."""
    return stacking(rng)


def lifted(rng: np.random.Generator) -> Shown:
    """The only object but the board, lifted and held."""
    shown = lifting(rng)
    return replace(shown, skills=(shown.skills[0], f"⟨{{hand, cube}}, {BOARD}⟩"))
