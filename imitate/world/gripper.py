"""How wide a gripper opens: measured on its shape, as the gap between the fingertips."""

from __future__ import annotations

import numpy as np

from imitate.geometry import Array, compose
from imitate.world.body import Body, load_body, pose_body
from imitate.world.engine import Client, open_client
from imitate.world.robot import Robot

_DEPTH = 0.015
"""m from the tool-centre point back towards the hand over which the gap is measured."""
_FARTHEST = 0.3
"""m on either side that is searched for a finger."""


def opening(robot: Robot, closed: float = 0.0) -> float:
    """The gap (m) between the fingertips, along the tool-centre point's y.

    Args:
        robot: its description.
        closed: 0 is open, 1 closed.
    """
    return float(sum(gaps(robot, closed)))


def gaps(robot: Robot, closed: float = 0.0) -> tuple[float, float]:
    """From the tool-centre point to the fingertip along −y and along +y, m; ∞ where there is none."""
    client = open_client()
    try:
        body = load_body(client, robot)
        fingers = [a + closed * (b - a) for a, b in zip(robot.finger_open, robot.finger_closed, strict=True)]
        pose_body(client, body, robot, [*robot.rest, *fingers])
        client.performCollisionDetection()
        return _gap(client, body, robot, -1.0), _gap(client, body, robot, 1.0)
    finally:
        client.disconnect()


def _gap(client: Client, body: Body, robot: Robot, side: float) -> float:
    state = client.getLinkState(body.number, body.hand, computeForwardKinematics=True)
    tcp = compose(np.array(state[4] + state[5]), np.array(robot.tcp))
    found = np.inf
    for depth in np.linspace(0, _DEPTH, 4):
        hit = client.rayTest(_beside(tcp, 0.0, depth), _beside(tcp, side * _FARTHEST, depth))[0]
        if hit[0] == body.number and hit[1] in body.finger_links:
            found = min(found, hit[2] * _FARTHEST)
    return found


def _beside(tcp: Array, y: float, depth: float) -> list[float]:
    point: list[float] = compose(tcp, np.array([0, y, -depth, 0, 0, 0, 1.0]))[:3].tolist()
    return point
