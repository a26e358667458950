"""Long demonstrations: one block after another is taken and put somewhere else, for as long as is asked."""

from __future__ import annotations

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import from_yaw

RATE = 30.0


def cycles(frames: int, objects: int, noise: float, rng: np.random.Generator) -> Demonstration:
    """``frames`` at 30 Hz on a table of 2 m; a cycle takes 5 to 8 s, with a rest in every third one."""
    return cycles_with_changes(frames, objects, noise, rng)[0]


def cycles_with_changes(
    frames: int, objects: int, noise: float, rng: np.random.Generator
) -> tuple[Demonstration, np.ndarray]:
    """The same, and (N, 2) from when to when (s) something starts or stops to be carried, rests included."""
    places = rng.uniform(-1, 1, (objects, 3)) * [1, 1, 0] + [0, 0, 0.025]
    at, hands, tracks, count = np.array([0.0, 0, 0.3]), [], [], 0
    changes = []
    while count < frames:
        k, goal = int(rng.integers(objects)), rng.uniform(-1, 1, 3) * [1, 1, 0] + [0, 0, 0.025]
        up = np.array([0, 0, 0.12])
        rest = rng.uniform(0.5, 3) if rng.uniform() < 1 / 3 else 0.1
        reach = [_move(at, places[k] + up, 1.2), _move(places[k] + up, places[k], 0.8)]
        carry = [_move(places[k], places[k] + up, 0.7), _move(places[k] + up, goal + up, 1.2)]
        carry += [_move(goal + up, goal, 0.7), np.repeat(goal[None], int(rest * RATE), axis=0)]
        lift = count + sum(map(len, reach))
        leave = lift + sum(map(len, carry))
        changes += [(lift, lift), (leave - len(carry[-1]), leave)]
        for stretch in (*reach, *carry, _move(goal, goal + up, 0.6)):
            here = np.repeat(places[None], len(stretch), axis=0)
            if any(stretch is part for part in carry):
                here[:, k] = stretch
            hands.append(stretch)
            tracks.append(here)
            count += len(stretch)
            places = here[-1].copy()
        at = goal + up
    hand, tracked = np.concatenate(hands)[:frames], np.concatenate(tracks)[:frames]
    demonstration = Demonstration(
        t=np.arange(frames) / RATE,
        hand=from_yaw(hand + rng.normal(scale=noise, size=hand.shape), np.zeros(frames)),
        objects=from_yaw(tracked + rng.normal(scale=noise, size=tracked.shape), np.zeros((frames, objects))),
        object_names=tuple(f"block{k}" for k in range(objects)),
        object_sizes=np.full((objects, 3), 0.05),
    )
    return demonstration, np.array([c for c in changes if c[1] < frames]).reshape(-1, 2) / RATE


def _move(start: np.ndarray, goal: np.ndarray, seconds: float) -> np.ndarray:
    u = np.linspace(0, 1, int(seconds * RATE), endpoint=False)[:, None]
    return start + (goal - start) * (10 * u**3 - 15 * u**4 + 6 * u**5)
