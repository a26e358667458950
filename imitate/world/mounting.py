"""Where on the table the arm stands: found by trying, with the whole demonstration within reach."""

from __future__ import annotations

import numpy as np

from imitate.demonstration import Demonstration
from imitate.errors import SceneError
from imitate.geometry import Array, from_yaw, resample
from imitate.settings import World as WorldSettings
from imitate.world.kinematics import Arm, Solution
from imitate.world.robot import Robot
from imitate.world.touching import touching

Place = tuple[Array, Solution]
"""a base (7,) and the joints along the demonstration from there."""


def place_base(robot: Robot, demonstration: Demonstration, settings: WorldSettings) -> tuple[Array, Array]:
    """Where on the table the arm stands, and its joints at the first frame.

    Tries a ring of places around the hand's workspace and takes the one that stays farthest from the joint
    limits while every pose of the hand is reached, no object stands in the base's way, and the arm touches
    neither itself nor the table.

    Returns:
        base (7,) and arm joints (A,).

    Raises:
        SceneError: no place reaches the whole demonstration; names the pose that fails at the best one.
    """
    at = np.linspace(0, demonstration.duration, max(2, int(demonstration.duration * settings.reach_rate)))
    hand = resample(demonstration.t - demonstration.t[0], demonstration.hand, at)
    centre = (hand[:, :2].min(axis=0) + hand[:, :2].max(axis=0)) / 2
    arm = Arm(robot)
    try:
        tried = [
            (base, arm.solve(base, hand, np.array(robot.rest), first_rounds=30))
            for base in _ring(robot, centre)
            if _clear(base, demonstration, robot.base_clearance)
        ]
        good = [t for t in tried if _reached(t[1], settings).all() and t[1].margin > settings.joint_margin]
        if not good:
            raise _out_of_reach(tried, hand, at, settings)
        good.sort(key=lambda place: place[1].margin, reverse=True)
        touches = ""
        for base, solution in good:
            touch = _first_touch(arm, (base, solution), at, settings)
            if not touch:
                return base, solution.joints[0]
            touches = touches or touch
    finally:
        arm.close()
    raise SceneError(
        f"wherever the arm stands, following the hand makes it touch itself or the table: {touches}. "
        "Demonstrate with the hand more upright, or choose another robot (--robot)."
    )


def _first_touch(arm: Arm, place: Place, at: Array, settings: WorldSettings) -> str:
    # What touches first, in words. Shapes are convex hulls: of links whose hulls overlap at rest they tell
    # nothing.
    base, solution = place
    usual = touching(arm, np.array(arm.robot.rest), -base[2])
    every = max(1, round(settings.reach_rate * settings.touch_interval))
    names = {number: name for name, number in arm.client.names(arm.body)[1].items()}
    names |= {-1: "the base", -2: "the table"}
    for time, joints in zip(at[::every], solution.joints[::every], strict=True):
        for pair, depth in touching(arm, joints, -base[2]).items():
            if pair not in usual and depth > settings.touch_tolerance:
                return (
                    f"{names[pair[1]]} and {names[pair[0]]} overlap by {depth * 1e3:.0f} mm at {time:.2f} s"
                )
    return ""


def _ring(robot: Robot, centre: Array) -> list[Array]:
    angles = np.arange(16) * np.pi / 8
    x, y = centre
    return [
        from_yaw([x + d * np.cos(a), y + d * np.sin(a), robot.base_height], a + np.pi - bearing)
        for bearing in robot.base_bearing
        for d in robot.base_distance
        for a in angles
    ]


def _clear(base: Array, demonstration: Demonstration, clearance: float) -> bool:
    gaps = np.linalg.norm(demonstration.objects[..., :2] - base[:2], axis=-1)
    return bool(np.all(gaps > clearance + np.nan_to_num(demonstration.object_sizes[:, :2]).max(axis=1) / 2))


def _reached(solution: Solution, settings: WorldSettings) -> Array:
    return np.asarray(
        (solution.distance < settings.reach_tolerance) & (solution.angle < settings.reach_angle), float
    )


def _out_of_reach(
    tried: list[tuple[Array, Solution]], hand: Array, at: Array, settings: WorldSettings
) -> SceneError:
    if not tried:
        return SceneError("the arm cannot stand anywhere: objects are in its way on every side.")
    best = max((s for _, s in tried), key=lambda s: float(np.mean(_reached(s, settings))) + 0.01 * s.margin)
    bad = ~_reached(best, settings).astype(bool)
    if not bad.any():
        return SceneError(
            "the hand's poses are reached only with a joint at its limit, wherever the arm stands. "
            "Another robot (--robot) may have the room."
        )
    off = np.maximum(best.distance / settings.reach_tolerance, best.angle / settings.reach_angle)
    k = int(np.argmax(np.where(bad, off, -1)))
    x, y, z = hand[k, :3]
    return SceneError(
        f"out of reach: the hand's pose at {at[k]:.2f} s, ({x:.3f}, {y:.3f}, {z:.3f}) m above the table, is "
        f"missed by {best.distance[k] * 1e3:.0f} mm and {np.rad2deg(best.angle[k]):.0f}° wherever the arm "
        "stands. Demonstrate within about 0.6 m, or choose another robot (--robot)."
    )
