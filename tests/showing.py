"""Synthetic demonstrations of other tasks than stacking, with known skills: a hand that follows a script."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array, align_signs, compose, from_yaw, inverse, normalised, quaternion_multiply

UP = np.array([0.0, 0, 0.12])
HOME = np.array([0.0, -0.35, 0.25])


@dataclass(frozen=True)
class Move:
    """The hand goes to ``to``, or turns about the vertical through ``about``, with what it holds.

    Where ``wrist`` is false, the hand keeps its orientation while it turns.
    """

    seconds: float
    to: Array | None = None
    about: Array | None = None
    angle: float = 0.0
    holds: tuple[str, ...] = ()
    wrist: bool = True
    share: float = 1.0
    """of the hand's displacement that what is held goes along; less for a nudge."""


@dataclass(frozen=True)
class Shown:
    """A script: objects at their start, what the hand does, and the skills that are in it."""

    objects: dict[str, Array]
    moves: tuple[Move, ...]
    skills: tuple[str, ...]
    home: Array


@dataclass(frozen=True)
class Camera:
    """How it is seen: frames/s, noise per axis in metres and of orientations in radians, what is lost."""

    rate: float = 30.0
    noise: float = 0.0
    turn_noise: float = 0.0
    jitter: float = 0.0
    """of a frame's time, as a share of the time between frames."""
    missing: float = 0.0
    """share of an object's poses that are not seen, in stretches of a third of a second."""
    freeze: bool = False
    """whether what is not seen repeats its last pose instead."""


def film(what: Shown, camera: Camera, rng: np.random.Generator, speed: float = 1.0) -> Demonstration:
    """What a camera sees of the script."""
    end = sum(move.seconds for move in what.moves) / speed
    steps = np.arange(0, end, 1 / camera.rate)
    t = steps + camera.jitter / camera.rate * rng.uniform(-0.5, 0.5, len(steps))
    hand, objects = _performed(what, np.clip(t * speed, 0, None))
    names = tuple(what.objects)
    bodies = [_seen(hand, camera, rng)] + [_seen(objects[name], camera, rng) for name in names]
    lost = [_lost(t, camera, rng) for _ in names]
    for body, gone in zip(bodies[1:], lost, strict=True):
        body[gone] = _last_seen(body, gone) if camera.freeze else np.nan
    sizes = np.full((len(names), 3), 0.05)
    return Demonstration(t, bodies[0], np.stack(bodies[1:], axis=1), names, sizes)


def _performed(what: Shown, t: Array) -> tuple[Array, dict[str, Array]]:
    """The hand's poses (T, 7) and each object's, at times ``t`` of the script."""
    hand = np.tile(from_yaw(what.home, 0.0), (len(t), 1))
    objects = {name: np.tile(pose, (len(t), 1)) for name, pose in what.objects.items()}
    now, began = from_yaw(what.home, 0.0), 0.0
    for move in what.moves:
        u = np.clip((t - began) / max(move.seconds, 1e-9), 0, 1)
        path = _path(now, move, 10 * u**3 - 15 * u**4 + 6 * u**5)
        after = t >= began
        hand[after] = path[after]
        for name in move.holds:
            start = _at(objects[name], after, what.objects[name])
            motion = _path(now, replace(move, wrist=True), move.share * (10 * u**3 - 15 * u**4 + 6 * u**5))
            objects[name][after] = compose(compose(motion, inverse(now)), start)[after]
        now, began = _path(now, move, np.ones(1))[0], began + move.seconds
    return hand, objects


def _at(track: Array, after: Array, first: Array) -> Array:
    before = np.flatnonzero(~after)
    return first if not len(before) else track[before[-1]] if not after.any() else track[after][0]


def _path(now: Array, move: Move, u: Array) -> Array:
    if move.about is None:
        to = now[:3] if move.to is None else move.to
        spin = from_yaw(np.zeros((len(u), 3)), move.angle * u)[:, 3:]
        return np.concatenate(
            [now[:3] + u[:, None] * (to - now[:3]), quaternion_multiply(spin, now[3:])], axis=1
        )
    axis = np.append(move.about, [0.0, 0, 0, 1])
    turned = compose(
        compose(compose(axis, from_yaw(np.zeros((len(u), 3)), move.angle * u)), inverse(axis)), now
    )
    if not move.wrist:
        turned[:, 3:] = now[3:]
    return turned


def _seen(track: Array, camera: Camera, rng: np.random.Generator) -> Array:
    track = track.copy()
    track[:, :3] += rng.normal(scale=camera.noise, size=(len(track), 3)) if camera.noise else 0
    if camera.turn_noise:
        small = np.column_stack(
            [rng.normal(scale=camera.turn_noise / 2, size=(len(track), 3)), np.ones(len(track))]
        )
        track[:, 3:] = quaternion_multiply(small, track[:, 3:])
    return align_signs(normalised(track))


def _lost(t: Array, camera: Camera, rng: np.random.Generator) -> Array:
    gone = np.zeros(len(t), bool)
    while gone.mean() < camera.missing:
        start = rng.uniform(t[0], t[-1])
        gone |= (t > start) & (t < start + 1 / 3)
    gone[[0, -1]] = False
    return gone


def _last_seen(body: Array, gone: Array) -> Array:
    last = np.maximum.accumulate(np.where(gone, 0, np.arange(len(body))))
    return np.asarray(body[last[gone]])


def spread(count: int, rng: np.random.Generator, apart: float = 0.12) -> Array:
    """Points (count, 3) on a table, at least ``apart`` from each other."""
    while True:
        points = np.column_stack([rng.uniform(-0.3, 0.3, (count, 2)), np.full(count, 0.025)])
        distances = np.linalg.norm(points[:, None] - points[None], axis=-1) + np.eye(count)
        if distances.min() > apart:
            return points


def fetch(name: str, start: Array, goal: Array, pause: float = 0.2) -> Iterator[Move]:
    """Reach for an object above its place, put it down at its goal; the hand stays there."""
    held = (name,)
    yield from (Move(1.2, start + UP), Move(0.7, start), Move(pause), Move(0.6, start + UP, holds=held))
    yield from (
        Move(1.0, goal + UP, holds=held),
        Move(0.7, goal, holds=held),
        Move(pause),
        Move(0.5, goal + UP),
    )


def placed(**points: Array) -> dict[str, Array]:
    """Upright poses at points."""
    return {name: from_yaw(point, 0.0) for name, point in points.items()}


def sorting(rng: np.random.Generator, count: int = 4) -> Shown:
    """Objects that go to one bin each; the hand retreats at the end."""
    points = spread(2 * count, rng)
    things = placed(**{f"thing{k}": points[k] for k in range(count)})
    bins = placed(**{f"bin{k}": points[count + k] for k in range(count)})
    moves: list[Move] = []
    skills: list[str] = []
    for k in rng.permutation(count):
        moves += fetch(f"thing{k}", points[k], points[count + k])
        skills += [f"⟨{{hand}}, thing{k}⟩", f"⟨{{hand, thing{k}}}, bin{k}⟩"]
    skills.append(f"⟨{{hand}}, thing{k}⟩")
    return Shown({**things, **bins}, (*moves, Move(1.0, HOME)), tuple(skills), HOME)


def lifting(rng: np.random.Generator) -> Shown:
    """The only object there is, lifted and held."""
    (cube,) = spread(1, rng)
    moves = (Move(1.2, cube + UP), Move(0.8, cube), Move(0.2), Move(1.0, cube + UP, holds=("cube",)))
    return Shown(placed(cube=cube), (*moves, Move(0.3)), ("⟨{hand}, cube⟩", "⟨{hand, cube}, table⟩"), HOME)


def opening(rng: np.random.Generator, wrist: bool = True) -> Shown:
    """A door turned by its rim about its origin, which lies on the hinge; a cup stands by."""
    hinge, cup = np.array([0.1, 0.3, 0.15]), np.array([0.3, -0.3, 0.025])
    rim = hinge + np.array([-0.3, 0, 0])
    pull = Move(1.5, about=hinge, angle=float(rng.uniform(0.6, 1.2)), holds=("door",), wrist=wrist)
    before = rim - np.array([0, 0.1, 0])
    moves = (Move(1.5, before), Move(0.6, rim), Move(0.3), pull, Move(0.3), Move(1.0, HOME))
    objects = placed(door=hinge, frame=hinge + np.array([-0.15, 0.02, 0]), cup=cup)
    return Shown(objects, moves, ("⟨{hand}, door⟩", "⟨{hand, door}, frame⟩", "⟨{hand}, door⟩"), HOME)


def pulling(rng: np.random.Generator) -> Shown:
    """A drawer pulled by its handle, 15 cm before its origin; its cabinet behind it, a cup on the table."""
    cabinet = np.array([rng.uniform(-0.2, 0.2), 0.35, 0.1])
    drawer = cabinet + np.array([0, -0.02, 0.02])
    handle = drawer + np.array([0, -0.15, 0])
    out = handle + np.array([0, -rng.uniform(0.1, 0.2), 0])
    cup = np.array([0.3, -0.3, 0.025])
    moves = (
        *(Move(1.5, handle - np.array([0, 0.1, 0])), Move(0.6, handle), Move(0.3)),
        *(Move(1.2, out, holds=("drawer",)), Move(0.3), Move(1.0, HOME)),
    )
    objects = placed(drawer=drawer, cabinet=cabinet, cup=cup)
    return Shown(objects, moves, ("⟨{hand}, drawer⟩", "⟨{hand, drawer}, cabinet⟩", "⟨{hand}, drawer⟩"), HOME)


def twisting(rng: np.random.Generator) -> Shown:
    """A knob turned on the spot, its origin under the hand; its stove beside it, a cup by."""
    knob = spread(1, rng)[0] + [0, 0, 0.1]
    twist = Move(1.2, knob, angle=float(rng.uniform(1.0, 1.6)), holds=("knob",))
    moves = (Move(1.2, knob + UP), Move(0.8, knob), Move(0.3), twist, Move(0.3), Move(0.8, knob + UP))
    objects = placed(knob=knob, stove=knob + np.array([0.05, 0, -0.02]), cup=np.array([0.4, 0.4, 0.025]))
    return Shown(objects, moves, ("⟨{hand}, knob⟩", "⟨{hand, knob}, stove⟩", "⟨{hand}, knob⟩"), HOME)


def nudging(rng: np.random.Generator) -> Shown:
    """Stacking, with another block, or the same, moved by up to 2 cm in passing."""
    blue, green, red = spread(3, rng)
    name, where = ("red", red) if rng.uniform() < 0.5 else ("blue", blue)
    way = rng.normal(size=2)
    way = np.append(way / np.linalg.norm(way), 0.0)
    far = rng.uniform(0.005, 0.02)
    nudge = (
        *(Move(1.2, where - 0.1 * way), Move(0.4, where - 0.04 * way)),
        *(Move(far / 0.06, where + (far - 0.04) * way, holds=(name,)), Move(0.5, where - 0.1 * way)),
    )
    start = blue + far * way if name == "blue" else blue
    goal = green + np.array([0, 0, 0.05])
    moves = (*nudge, *fetch("blue", start, goal), Move(1.0, HOME))
    skills = ("⟨{hand}, blue⟩", "⟨{hand, blue}, green⟩", "⟨{hand}, blue⟩")
    return Shown(placed(blue=blue, green=green, red=red), moves, skills, HOME)


def twice(rng: np.random.Generator) -> Shown:
    """Two stackings, with a rest at home between them: the hand goes to what it takes next."""
    blue, green, red, white = spread(4, rng)
    up = np.array([0, 0, 0.05])
    moves = (
        *(*fetch("blue", blue, green + up), Move(1.0, HOME), Move(1.5)),
        *(*fetch("red", red, white + up), Move(1.0, HOME), Move(1.0)),
    )
    skills = (
        *("⟨{hand}, blue⟩", "⟨{hand, blue}, green⟩", "⟨{hand}, red⟩"),
        *("⟨{hand, red}, white⟩", "⟨{hand}, red⟩"),
    )
    return Shown(placed(blue=blue, green=green, red=red, white=white), moves, skills, HOME)


def touching(rng: np.random.Generator) -> Shown:
    """One block touched, then another one put on the third: two reaches in a row."""
    blue, green, red = spread(3, rng)
    touch = (Move(1.2, red + UP), Move(0.7, red), Move(float(rng.uniform(0.4, 2.0))), Move(0.5, red + UP))
    moves = (*touch, *fetch("blue", blue, green + np.array([0, 0, 0.05])), Move(1.0, HOME))
    skills = ("⟨{hand}, red⟩", "⟨{hand}, blue⟩", "⟨{hand, blue}, green⟩", "⟨{hand}, blue⟩")
    return Shown(placed(blue=blue, green=green, red=red), moves, skills, HOME)


def visiting(rng: np.random.Generator) -> Shown:
    """Three objects touched in turn, nothing carried."""
    blue, green, red = spread(3, rng)
    places = {"blue": blue, "green": green, "red": red}
    order = [str(name) for name in rng.permutation(list(places))]
    moves = [
        move
        for p in (places[name] for name in order)
        for move in (Move(1.2, p + UP), Move(0.7, p), Move(0.8), Move(0.5, p + UP))
    ]
    skills = tuple(f"⟨{{hand}}, {name}⟩" for name in order)
    return Shown(placed(**places), (*moves, Move(1.0, HOME)), skills, HOME)


def stacking(rng: np.random.Generator) -> Shown:
    """One block put on another, a third one beside them; the hand retreats."""
    blue, green, red = spread(3, rng)
    moves = (*fetch("blue", blue, green + np.array([0, 0, 0.05]), 0.3), Move(1.0, HOME))
    skills = ("⟨{hand}, blue⟩", "⟨{hand, blue}, green⟩", "⟨{hand}, blue⟩")
    return Shown(placed(blue=blue, green=green, red=red), moves, skills, HOME)


TASKS: dict[str, Callable[[np.random.Generator], Shown]] = {
    "stacking": stacking,
    "sorting four": sorting,
    "lifting the only object": lifting,
    "door about its origin": opening,
    "door, hooked": lambda rng: opening(rng, wrist=False),
    "drawer": pulling,
    "knob": twisting,
    "nudge": nudging,
    "twice with a rest": twice,
    "touch and stack": touching,
    "touch three": visiting,
}
CAMERAS = {
    "exact": Camera(),
    "noise 4 mm, 2°": Camera(noise=0.004, turn_noise=0.035),
    "10 Hz": Camera(rate=10.0),
    "100 Hz, irregular": Camera(rate=100.0, jitter=0.9),
    "a fifth missing": Camera(missing=0.2, noise=0.002),
    "a fifth frozen": Camera(missing=0.2, freeze=True),
    "a fifth frozen, noise 2 mm": Camera(missing=0.2, noise=0.002, freeze=True),
}
