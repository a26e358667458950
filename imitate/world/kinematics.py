"""Inverse kinematics over whole trajectories.

A server of its own, so that solving never touches the physics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imitate.geometry import Array, angle_between, compose, inverse
from imitate.world.body import load_body, pose_body
from imitate.world.engine import open_client, pybullet
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
        loaded = load_body(self.client, robot)
        pose_body(self.client, loaded, robot, [*robot.rest, *robot.finger_open])
        self.body, self.joints, self.link = loaded.number, list(loaded.arm), loaded.hand
        info = [self.client.getJointInfo(self.body, j) for j in range(self.client.getNumJoints(self.body))]
        self.lower = np.array([info[j][8] if info[j][8] < info[j][9] else -np.inf for j in self.joints])
        self.upper = np.array([info[j][9] if info[j][8] < info[j][9] else np.inf for j in self.joints])
        movable = [j for j, of in enumerate(info) if of[2] != pybullet.JOINT_FIXED]
        self.columns = [movable.index(j) for j in self.joints]
        state = self.client.getLinkState(self.body, self.link)
        self._turn = np.array((0.0, 0.0, 0.0) + state[3])
        self.tcp = np.array(robot.tcp)
        self.from_tcp = inverse(self.tcp)

    def close(self) -> None:
        """Disconnects from the server."""
        self.client.disconnect()

    def forward(self, base: Array, joints: Array) -> Array:
        """World pose (7,) of the tool-centre point for arm joints (A,) on a base (7,)."""
        self.put(joints.tolist())
        state = self.client.getLinkState(self.body, self.link, computeForwardKinematics=True)
        hand = np.array(state[4] + state[5])
        return compose(base, compose(hand, self.tcp))

    def solve(self, base: Array, poses: Array, seed: Array, first_rounds: int = 1) -> Solution:
        """Joints that bring the tool-centre point through world poses (C, 7), each from the one before.

        The orientations ±q are one, and no joint goes beyond its limits. The joints of ``seed`` (A,) are
        where the search starts, and the first pose is given ``first_rounds`` rounds of it.
        """
        wanted = compose(compose(inverse(base), poses), self.from_tcp)
        # PyBullet's solver takes the position of the link's frame, and the turn of its inertia's frame.
        asked = wanted if self._turn[6] == 1 else compose(wanted, self._turn)
        solve, state_of = self.client.calculateInverseKinematics, self.client.getLinkState
        self.put(seed.tolist())
        within = list(zip(self.columns, self.lower.tolist(), self.upper.tolist(), strict=True))
        out = np.empty((len(poses), len(self.joints)))
        reached = np.empty((len(poses), 7))
        for k, pose in enumerate(asked.tolist()):
            for _ in range(first_rounds if k == 0 else 1):
                found = solve(
                    self.body,
                    self.link,
                    pose[:3],
                    pose[3:],
                    maxNumIterations=20,
                    residualThreshold=1e-5,
                )
                joints = [min(max(found[c], low), high) for c, low, high in within]
                self.put(joints)
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

    def put(self, joints: list[float]) -> None:
        """Moves the arm's joints (A,) there at once."""
        self.client.resetJointStatesMultiDof(self.body, self.joints, [[position] for position in joints])
