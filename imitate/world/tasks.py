"""Tasks that the virtual hand makes up itself: by chance in places and speeds, with the right skills."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, compose, from_yaw, rotate
from imitate.world.moves import Moves
from imitate.world.performance import CLEARANCE, OPEN, WALL, Performance
from imitate.world.stage import BLOCKS

SIDES = (0.035, 0.055)
"""m, of blocks; half of them are cubes."""
TRAY = (0.15, 0.17)
"""m, length and width of the open box, wide enough for the fingers to open in."""
AREA = np.array([0.12, 0.16])
"""m from the middle, along x and y, within which objects are put."""
APART = 0.14
"""m between the middles of two objects at the start, at least."""
RISE = (0.07, 0.11)
"""m by which the hand rises on its way."""
FINGER = 0.0105
"""m from the tool-centre point to a face that is pushed: a finger's radius and a little air."""


def make_up(task: str, seed: int) -> Performance:
    """One performance of a task of `TASKS`; the same seed gives the same one."""
    return TASKS[task](np.random.default_rng([sum(task.encode()), seed]))


def _stack(g: np.random.Generator) -> Performance:
    sizes = np.array([_block(g), _block(g)])
    moves = _set(g, sizes, _scattered(g, sizes))
    _put_on(moves, g, 0, 1)
    _leave(moves, g)
    return moves.performance(0)


def _three(g: np.random.Generator) -> Performance:
    """Three blocks: the third is never touched, or put on top in the end."""
    sizes = np.array([_block(g) for _ in range(3)])
    moves = _set(g, sizes, _scattered(g, sizes))
    _put_on(moves, g, 0, 1)
    last = 0
    if g.random() < 0.5:
        _put_on(moves, g, 2, 0)
        last = 2
    _leave(moves, g)
    return moves.performance(last)


def _unstack(g: np.random.Generator) -> Performance:
    sizes = np.array([_block(g), _block(g)])
    apart = _scattered(g, sizes)
    starts = apart.copy()
    starts[0, :2] = apart[1, :2] + g.normal(0, 0.002, 2)
    starts[0, 2] += sizes[1, 2]
    starts[0, 3:] = _aligned(starts[0], apart[1], g)[3:]
    moves = _set(g, sizes, starts)
    _grasp(moves, g, 0)
    moves.carry(apart[0], g.uniform(*RISE))
    moves.let_go(OPEN, 1)
    _leave(moves, g)
    return moves.performance(0)


def _box(g: np.random.Generator) -> Performance:
    """A block into an open box."""
    sizes = np.array([_block(g), [*g.uniform(*TRAY, 2), g.uniform(0.04, 0.06)]])
    moves = _set(g, sizes, _scattered(g, sizes, apart=0.17))
    _grasp(moves, g, 0)
    inside = np.array([*g.uniform(-0.01, 0.01, 2), WALL + (sizes[0, 2] - sizes[1, 2]) / 2])
    goal = np.array([*compose(moves.where(1), [*inside, 0, 0, 0, 1])[:3], *moves.where(0)[3:]])
    moves.carry(_aligned(goal, moves.where(1), g), g.uniform(*RISE))
    moves.let_go(float(sizes[0].max()) + 0.02, 1)
    _leave(moves, g)
    return moves.performance(0, (moves.names[1],))


def _push(g: np.random.Generator) -> Performance:
    """A block along the table, up to another one."""
    sizes = np.array([_block(g), _block(g)])
    along = g.uniform(-np.pi / 3, np.pi / 3)  # 0: away from the camera
    ahead = np.array([np.cos(along), np.sin(along), 0])
    gap, way = g.uniform(0.01, 0.03), g.uniform(0.14, 0.2)
    target = from_yaw(
        [*(ahead[:2] * way / 2 + g.uniform(-0.03, 0.03, 2)), sizes[1, 2] / 2], along + g.normal(0, 0.1)
    )
    near = float(sizes[0, 0] + np.hypot(*sizes[1, :2])) / 2 + gap
    goal = from_yaw([*(target - near * np.pad(ahead, (0, 4)))[:2], sizes[0, 2] / 2], along)
    start = goal - way * np.pad(ahead, (0, 4))
    tilt = np.deg2rad(g.uniform(5, 20))
    z = np.sin(tilt) * ahead - np.cos(tilt) * np.array([0, 0, 1.0])
    y = np.array([-ahead[1], ahead[0], 0])
    turn = Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=1)).as_quat()
    opening = g.uniform(0.008, 0.018)
    moves = _set(g, sizes, np.stack([start, target]), opening=opening)
    behind = start[:3] - (sizes[0, 0] / 2 + FINGER / np.cos(tilt)) * ahead
    moves.go(np.concatenate([behind, turn]), g.uniform(*RISE), up=0, down=0.3)
    moves.hold(0, opening)
    moves.carry(goal, up=0, down=0)
    moves.let_go(opening, 1)
    _leave(moves, g)
    return moves.performance(0)


TASKS: dict[str, Callable[[np.random.Generator], Performance]] = {
    "stack": _stack,
    "box": _box,
    "push": _push,
    "unstack": _unstack,
    "three": _three,
}


def _set(g: np.random.Generator, sizes: Array, starts: Array, opening: float = OPEN) -> Moves:
    """The hand to one side, above the objects; each object has a paint of its own."""
    names = tuple(str(name) for name in g.permutation(BLOCKS)[: len(sizes)])
    side = g.choice([-1, 1])
    place = np.array([g.uniform(0.0, 0.12), side * g.uniform(0.12, 0.2), g.uniform(0.16, 0.22)])
    hand = compose(from_yaw(place, g.uniform(-0.3, 0.3)), _pointing_down(g))
    return Moves(names, sizes, starts, hand, opening, g)


def _put_on(moves: Moves, g: np.random.Generator, k: int, below: int) -> None:
    """Object ``k`` onto the middle of another one."""
    _grasp(moves, g, k)
    goal = moves.where(k).copy()
    goal[:2] = moves.where(below)[:2] + g.normal(0, 0.002, 2)
    goal[2] = moves.where(below)[2] + (moves.sizes[below, 2] + moves.sizes[k, 2]) / 2
    moves.carry(_aligned(goal, moves.where(below), g), g.uniform(*RISE))
    moves.let_go(OPEN, below)


def _grasp(moves: Moves, g: np.random.Generator, k: int) -> None:
    """From above, the fingers on two opposite faces, the left one towards −y."""
    block = moves.where(k)
    quarters = [compose(block, from_yaw([0, 0, 0], m * np.pi / 2)) for m in range(4)]
    m = int(np.argmax([rotate(q[3:], [0, 1.0, 0])[1] for q in quarters]))
    lower = np.array([0, 0, g.uniform(-0.005, 0.005), 0, 0, 0, 1])
    pose = compose(compose(quarters[m], lower), _pointing_down(g))
    moves.go(pose, g.uniform(*RISE))
    moves.hold(k, float(moves.sizes[k, 1 - m % 2]) + CLEARANCE)


def _leave(moves: Moves, g: np.random.Generator) -> None:
    """Up and away, then still."""
    away = np.array([g.uniform(0.02, 0.1), g.choice([-1, 1]) * g.uniform(0.05, 0.12), g.uniform(0.1, 0.14)])
    pose = moves.hand.copy()
    pose[:3] += away
    moves.go(pose, 0.02)
    moves.rest(0.5)


def _pointing_down(g: np.random.Generator) -> Array:
    """(7,) the hand in the frame of what it comes down on: its fingers lean along their own plane."""
    down = np.array([0.0, 0, 0, 0, 1, 0, 0])
    lean = Rotation.from_euler("y", g.uniform(-20, 20), degrees=True).as_quat()
    return compose(down, [0, 0, 0, *lean])


def _aligned(pose: Array, to: Array, g: np.random.Generator) -> Array:
    """``pose`` turned the short way until its sides are nearly parallel to those of ``to``, both upright."""
    yaw, other = (2 * np.arctan2(p[5], p[6]) for p in (pose, to))
    off = (other - yaw + np.pi / 4) % (np.pi / 2) - np.pi / 4
    return from_yaw(pose[:3], yaw + off + g.normal(0, 0.05))


def _block(g: np.random.Generator) -> Array:
    """(3,) the size of a cube or of a box."""
    return np.full(3, g.uniform(0.038, 0.052)) if g.random() < 0.5 else g.uniform(*SIDES, 3)


def _scattered(g: np.random.Generator, sizes: Array, apart: float = APART) -> Array:
    """(K, 7) objects on the table, their middles at least ``apart`` from each other."""
    while True:
        places = g.uniform(-AREA, AREA, (len(sizes), 2))
        between = np.linalg.norm(places[:, None] - places[None], axis=-1)
        if between[~np.eye(len(sizes), dtype=bool)].min() >= apart:
            break
    yaws = g.uniform(-np.pi / 4, np.pi / 4, len(sizes))
    return from_yaw(np.column_stack([places, sizes[:, 2] / 2]), yaws)
