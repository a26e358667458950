"""Where an arm touches itself or the table, so that it is never placed to do so."""

from __future__ import annotations

from imitate.geometry import Array
from imitate.world.engine import pybullet
from imitate.world.kinematics import Arm

Pair = tuple[int, int]
"""two links, by number: −1 is the robot's base, and −2 stands for the table."""

_TABLE = -2


def touching(arm: Arm, joints: Array, table: float) -> dict[Pair, float]:
    """Links that overlap, neighbours aside → by how much (m).

    The hand and what it carries are not compared with the table: how near they come is the demonstration's.

    Args:
        arm: on its server, its fingers open.
        joints: (A,) of the arm.
        table: its height (m) in the frame of the arm's base.
    """
    client, body = arm.client, arm.body
    arm.put(joints.tolist())
    parents = [client.getJointInfo(body, link)[16] for link in range(client.getNumJoints(body))]
    found: dict[Pair, float] = {}
    for point in client.getClosestPoints(body, body, 0.0):
        low, high = point[3], point[4]
        if low < high and parents[high] != low:
            found[low, high] = max(found.get((low, high), 0.0), -point[8])
    moved = _with_descendants({arm.joints[0]}, parents) - _with_descendants({arm.link}, parents)
    plane = client.createMultiBody(0, client.createCollisionShape(pybullet.GEOM_PLANE), -1, [0, 0, table])
    for point in client.getClosestPoints(body, plane, 0.0):
        if point[3] in moved:
            found[_TABLE, point[3]] = max(found.get((_TABLE, point[3]), 0.0), -point[8])
    client.removeBody(plane)
    return found


def _with_descendants(links: set[int], parents: list[int]) -> set[int]:
    # Parents have lower numbers than what they carry.
    found = set(links)
    for link, parent in enumerate(parents):
        if parent in found:
            found.add(link)
    return found
