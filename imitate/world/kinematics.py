"""Inverse kinematics over whole trajectories, and where to put the arm.

A server of its own, so that solving never touches the physics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imitate.demonstration import Demonstration
from imitate.errors import SceneError
from imitate.geometry import Array, angle_between, compose, from_yaw, inverse, resample
from imitate.settings import World as WorldSettings
from imitate.world.engine import Client, open_client, pybullet
from imitate.world.quiet import quiet
from imitate.world.robot import Robot


@dataclass(frozen=True)
class Solution:
    """Joint positions along a trajectory.

    Attributes:
        joints: (C, A) rad.
        distance: (C,) m, angle: (C,) rad: what is left between the hand and the pose asked for.
        margin: smallest distance (rad) to a joint limit along the trajectory.
    """

    joints: Array
    distance: Array
    angle: Array
    margin: float


class Arm:
    """The robot's kinematics alone.

    Raises:
        SceneError: the description names a file that is no URDF, or joints or a link that it does not have.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.client = open_client()
        self.body = _loaded(self.client, robot)
        joints, links = self.client.names(self.body)
        self.joints = [joints[name] for name in robot.arm]
        self.link = links[robot.hand_link]
        info = [self.client.getJointInfo(self.body, j) for j in self.joints]
        self.lower = np.array([i[8] for i in info])
        self.upper = np.array([i[9] for i in info])
        movable = [
            j
            for j in sorted(joints.values())
            if self.client.getJointInfo(self.body, j)[2] != pybullet.JOINT_FIXED
        ]
        self.columns = [movable.index(j) for j in self.joints]
        self.tcp = np.array(robot.tcp)
        self.from_tcp = inverse(self.tcp)

    def close(self) -> None:
        """Disconnects from the server."""
        self.client.disconnect()

    def forward(self, base: Array, joints: Array) -> Array:
        """World pose (7,) of the tool-centre point for arm joints (A,) on a base (7,)."""
        self._put(joints.tolist())
        state = self.client.getLinkState(self.body, self.link, computeForwardKinematics=True)
        hand = np.array(state[4] + state[5])
        return compose(base, compose(hand, self.tcp))

    def solve(self, base: Array, poses: Array, seed: Array, first_rounds: int = 1) -> Solution:
        """Joints that bring the tool-centre point through world poses (C, 7), each from the one before.

        The orientations ±q are one; the joints of ``seed`` (A,) are where the search starts, and the first
        pose is given ``first_rounds`` rounds of it.
        """
        wanted = compose(compose(inverse(base), poses), self.from_tcp)
        solve, state_of = self.client.calculateInverseKinematics, self.client.getLinkState
        self._put(seed.tolist())
        out = np.empty((len(poses), len(self.joints)))
        reached = np.empty((len(poses), 7))
        for k, pose in enumerate(wanted.tolist()):
            for _ in range(first_rounds if k == 0 else 1):
                found = solve(
                    self.body,
                    self.link,
                    pose[:3],
                    pose[3:],
                    maxNumIterations=20,
                    residualThreshold=1e-5,
                )
                joints = [found[c] for c in self.columns]
                self._put(joints)
            out[k] = joints
            state = state_of(self.body, self.link, computeForwardKinematics=True)
            reached[k] = state[4] + state[5]
        margin = float(np.min(np.minimum(out - self.lower, self.upper - out)))
        return Solution(
            joints=out,
            distance=np.linalg.norm(reached[:, :3] - wanted[:, :3], axis=1),
            angle=angle_between(reached, wanted),
            margin=margin,
        )

    def _put(self, joints: list[float]) -> None:
        self.client.resetJointStatesMultiDof(self.body, self.joints, [[position] for position in joints])


def _loaded(client: Client, robot: Robot) -> int:
    try:
        with quiet(1):  # a missing file is announced on stdout before it is an error
            body = int(client.loadURDF(robot.urdf, useFixedBase=1))
    except pybullet.error:
        raise SceneError(
            f"{robot.urdf}: cannot be loaded as a robot. Expected a URDF file: an absolute path, or one "
            "beside the robot's TOML file or within pybullet_data."
        ) from None
    joints, links = client.names(body)
    for kind, wanted, has in (
        ("joint", robot.arm + robot.fingers, joints),
        ("link", (robot.hand_link,), links),
    ):
        if missing := [name for name in wanted if name not in has]:
            raise SceneError(f"{robot.urdf}: no {kind} {', '.join(missing)}; it has {', '.join(has)}.")
    return body


def place_base(robot: Robot, demonstration: Demonstration, settings: WorldSettings) -> tuple[Array, Array]:
    """Where on the table the arm stands, and its joints at the first frame.

    Tries a ring of places around the hand's workspace and takes the one that stays farthest from the joint
    limits while every pose of the hand is reached and no object stands in the base's way.

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
            if _clear(base, demonstration)
        ]
    finally:
        arm.close()
    good = [t for t in tried if _reached(t[1], settings).all() and t[1].margin > settings.joint_margin]
    if not good:
        raise _out_of_reach(tried, hand, at, settings)
    base, solution = max(good, key=lambda t: t[1].margin)
    return base, solution.joints[0]


def _ring(robot: Robot, centre: Array) -> list[Array]:
    angles = np.arange(16) * np.pi / 8
    return [
        from_yaw([centre[0] + d * np.cos(a), centre[1] + d * np.sin(a), 0.0], a + np.pi)
        for d in robot.base_distance
        for a in angles
    ]


def _clear(base: Array, demonstration: Demonstration) -> bool:
    gaps = np.linalg.norm(demonstration.objects[..., :2] - base[:2], axis=-1)
    return bool(np.all(gaps > 0.2 + np.nan_to_num(demonstration.object_sizes[:, :2]).max(axis=1) / 2))


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
            "Another robot (setting world.robot) may have the room."
        )
    k = int(np.argmax(np.where(bad, best.distance, -1)))
    x, y, z = hand[k, :3]
    return SceneError(
        f"out of reach: the hand's pose at {at[k]:.2f} s, ({x:.3f}, {y:.3f}, {z:.3f}) m above the table, is "
        f"missed by {best.distance[k] * 1e3:.0f} mm and {np.rad2deg(best.angle[k]):.0f}° wherever the arm "
        "stands. Demonstrate within about 0.6 m, or choose another robot (setting world.robot)."
    )
