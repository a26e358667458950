"""A robot's body in a physics server: loaded, its fingers one mechanism, what it does not use held still."""

from __future__ import annotations

from dataclasses import dataclass

from imitate.errors import SceneError
from imitate.geometry import IDENTITY, Array
from imitate.world.engine import Client, pybullet
from imitate.world.quiet import quiet
from imitate.world.robot import Robot

_HOLDING = 1e4
"""N or Nm, the most that holds an unused joint where it is: far above what moves any arm."""
_GEAR_FORCE = 50.0
"""N or Nm, the most with which the fingers' linkage keeps them together."""


@dataclass(frozen=True)
class Body:
    """PyBullet's numbers for a robot.

    Attributes:
        number: of the body.
        arm, fingers, followers: of joints, in the description's order.
        held: of the movable joints that are none of these → position.
        hand: of the link that carries the fingers.
        finger_links: of every link that moves with a finger.
    """

    number: int
    arm: tuple[int, ...]
    fingers: tuple[int, ...]
    followers: tuple[int, ...]
    held: dict[int, float]
    hand: int
    finger_links: tuple[int, ...]


def load_body(client: Client, robot: Robot, base: Array = IDENTITY, flags: int = 0) -> Body:
    """A robot's body, its base fixed at ``base`` (7,).

    Raises:
        SceneError: the description names a file that cannot be loaded, or joints or a link that it lacks.
    """
    number = _loaded(client, robot, base, flags)
    joints, links = client.names(number)
    movable = {
        name: joint
        for name, joint in joints.items()
        if client.getJointInfo(number, joint)[2] in (pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC)
    }
    _check_names(robot, movable, links)
    used = {*robot.arm, *robot.fingers, *robot.followers}
    fingers = tuple(movable[name] for name in robot.fingers)
    followers = tuple(movable[name] for name in robot.followers)
    return Body(
        number,
        tuple(movable[name] for name in robot.arm),
        fingers,
        followers,
        {joint: robot.held.get(name, 0.0) for name, joint in movable.items() if name not in used},
        links[robot.hand_link],
        _descendants(client, number, {*fingers, *followers}),
    )


def _loaded(client: Client, robot: Robot, base: Array, flags: int) -> int:
    place = (base[:3].tolist(), base[3:].tolist())
    try:
        with quiet(1):  # a missing file is announced on stdout before it is an error
            if not robot.urdf.endswith(".sdf"):
                return int(client.loadURDF(robot.urdf, *place, useFixedBase=1, flags=flags))
            (number,) = client.loadSDF(robot.urdf)
    except (pybullet.error, ValueError):
        raise SceneError(
            f"{robot.urdf}: cannot be loaded as a robot. Expected a URDF file, or an SDF file of one model: "
            "an absolute path, or one beside the robot's TOML file or within pybullet_data."
        ) from None
    client.resetBasePositionAndOrientation(number, *place)
    return int(number)


def _check_names(robot: Robot, movable: dict[str, int], links: dict[str, int]) -> None:
    joints = (*robot.arm, *robot.fingers, *robot.followers, *robot.held)
    for kind, wanted, has in (("joint", joints, movable), ("link", (robot.hand_link,), links)):
        if missing := [name for name in dict.fromkeys(wanted) if name not in has]:
            which = "its movable joints are" if kind == "joint" else "it has"
            raise SceneError(f"{robot.urdf}: no {kind} {', '.join(missing)}; {which} {', '.join(has)}.")


def _descendants(client: Client, number: int, roots: set[int]) -> tuple[int, ...]:
    # Links are numbered parents first, and a link has the number of the joint above it.
    found = set(roots)
    for link in range(client.getNumJoints(number)):
        if client.getJointInfo(number, link)[16] in found:
            found.add(link)
    return tuple(sorted(found))


def pose_body(client: Client, body: Body, robot: Robot, positions: list[float]) -> None:
    """Puts arm and finger joints where they are to be, and every other joint where these have it."""
    for joint, position in zip(body.arm + body.fingers, positions, strict=True):
        client.resetJointState(body.number, joint, position)
    closed = _share_closed(robot, positions[len(body.arm)])
    for joint, (opened, shut) in zip(body.followers, robot.followers.values(), strict=True):
        client.resetJointState(body.number, joint, opened + closed * (shut - opened))
    for joint, position in body.held.items():
        client.resetJointState(body.number, joint, position)


def _share_closed(robot: Robot, first_finger: float) -> float:
    return (first_finger - robot.finger_open[0]) / (robot.finger_closed[0] - robot.finger_open[0])


def make_mechanism(client: Client, body: Body, robot: Robot) -> None:
    """Couples the fingers and what follows them into one mechanism, and holds the joints not used."""
    for joint, position in body.held.items():
        _hold(client, body, joint, position)
    for joint in body.followers:  # the linkage moves them, no motor of their own
        client.setJointMotorControl2(body.number, joint, pybullet.VELOCITY_CONTROL, force=0)
    joints = body.fingers + body.followers
    travels = [*zip(robot.finger_open, robot.finger_closed, strict=True), *robot.followers.values()]
    opened, closed = travels[0]
    for joint, (other_open, other_closed) in zip(joints[1:], travels[1:], strict=True):
        if other_open == other_closed:
            _hold(client, body, joint, other_open)
            continue
        # The engine keeps first + ratio · other at a target: all run from open to closed together.
        ratio = -(closed - opened) / (other_closed - other_open)
        axis, zero = [1, 0, 0], [0, 0, 0]
        gear = client.createConstraint(
            body.number, joints[0], body.number, joint, pybullet.JOINT_GEAR, axis, zero, zero
        )
        client.changeConstraint(
            gear,
            gearRatio=ratio,
            erp=0.1,
            maxForce=_GEAR_FORCE,
            relativePositionTarget=opened + ratio * other_open,
        )


def _hold(client: Client, body: Body, joint: int, position: float) -> None:
    client.setJointMotorControl2(
        body.number, joint, pybullet.POSITION_CONTROL, targetPosition=position, force=_HOLDING
    )
