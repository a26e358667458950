"""Run policies in physics; every step reported.

A control tick lasts a whole number of physics steps. At each tick the arm's joints are given a position and
the gripper a force; a trial is its start and those commands, which is what makes it replayable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np

from imitate.demonstration import TABLE
from imitate.geometry import IDENTITY, Array, compose, relative
from imitate.policy.force import forces
from imitate.policy.movement import movement
from imitate.record import Sightings, Start, TrialRecord, as_seen
from imitate.settings import Settings
from imitate.skill import Policy, policy_ticks
from imitate.world.engine import pybullet
from imitate.world.kinematics import Arm
from imitate.world.scene import World


class Watch(Protocol):
    """Who says where objects are while a trial runs, instead of the physics."""

    def look(self, step: int, joints: Array, hand: Array, objects: Array) -> None:
        """Asked to look, the physics standing still.

        Args:
            step: physics steps taken so far.
            joints: (J,) positions, as in a record.
            hand: (7,) world pose by the joints.
            objects: (K, 7) world poses, as they really are: what there is to be seen.
        """

    def pose_of(self, index: int) -> Array | None:
        """(7,) world pose of an object as it was seen last; None where it never was."""


_Command = Callable[[list[float], list[float], float], None]
_Observe = Callable[[], None]


@dataclass(frozen=True)
class Outcome:
    """What a trial gave.

    Attributes:
        record: its steps.
        unreachable: in words the pose that stopped it, if one was out of reach.
        unseen: in words the reference that stopped it, if it was watched and that was never seen.
        seen: where objects were seen, if it was watched.
    """

    record: TrialRecord
    unreachable: str = ""
    unseen: str = ""
    seen: Sightings | None = None

    @property
    def believed(self) -> TrialRecord:
        """The record with objects where they were seen, if it was watched."""
        return as_seen(self.record, self.seen)


class Simulator:
    """A world and the arm's kinematics, for any number of trials of one scene."""

    def __init__(self, world: World, settings: Settings) -> None:
        self.world = world
        self.settings = settings
        self.arm = Arm(world.robot)
        self.control_every = settings.world.physics_rate // settings.world.control_rate
        self._grid = (1 / settings.world.physics_rate, self.control_every)

    def close(self) -> None:
        """Disconnects both servers."""
        self.world.close()
        self.arm.close()

    def run(self, start: Start, policies: Sequence[Policy], watch: Watch | None = None) -> Outcome:
        """Runs policies one after another from ``start``, each followed by a moment of holding still.

        A pose out of reach ends the trial there, and so does a reference that ``watch`` has never seen. It
        looks at the start, at the settings' rate from each policy's start on, and where one ends.
        """
        self.world.reset(start)
        steps = _Steps()
        look = self._looker(watch, steps) if watch else None
        if look:
            look()
        commands = [np.append(start.joints[: len(self.arm.joints)], start.force)]
        option_starts: list[int] = []
        unreachable = unseen = ""
        for policy in policies:
            option_starts.append(len(steps.joint_positions))
            reference = self._pose_of(policy.reference, watch)
            if reference is None:
                plan = commands[-1][None]
                unseen = f"{policy.reference} was not seen when the skill was to start"
            else:
                plan, unreachable = self._plan(policy, reference, commands[-1])
            self._execute(np.vstack([commands[-1], plan]), steps, look=look)
            commands.extend(plan)
            if unreachable or unseen:
                break
        record = steps.record(start, self._grid, tuple(option_starts), np.array(commands[1:]))
        return Outcome(record, unreachable, unseen)

    def resimulate(self, record: TrialRecord) -> TrialRecord:
        """The trial that results from a record's start and commands."""
        self.world.reset(record.start)
        steps = _Steps()
        first = np.append(record.start.joints[: len(self.arm.joints)], record.start.force)
        self._execute(np.vstack([first, record.commands]), steps, record.steps)
        return steps.record(record.start, self._grid, record.option_starts, record.commands)

    def _plan(self, policy: Policy, reference: Array, last: Array) -> tuple[Array, str]:
        # Commands (C, A + 1) of a policy from where the world is now, cut at the first pose out of reach.
        s, world = self.settings, self.world
        wait, ticks = policy_ticks(policy, s.world.control_rate)
        hand = compose(reference, self.movement(policy, relative(reference, self.hand_pose()), ticks))
        solution = self.arm.solve(world.spec.base, hand, last[:-1])
        hold = round(s.world.settle_time * s.world.control_rate)
        forces = self.forces(policy, wait + ticks, float(last[-1]))
        waiting = np.repeat(last[None, :-1], wait, axis=0)
        plan = np.column_stack([np.vstack([waiting, solution.joints]), forces])
        bad = (solution.distance > s.world.reach_tolerance) | (solution.angle > s.world.reach_angle)
        if not bad.any():
            return np.vstack([plan, np.repeat(plan[-1:], hold, axis=0)]), ""
        first = int(np.argmax(bad))
        x, y, z = hand[first, :3]
        at = (wait + first) / s.world.control_rate
        where = f"({x:.3f}, {y:.3f}, {z:.3f}) m"
        return plan[: max(wait + first, 1)], f"out of reach {at:.2f} s into the skill: {where}"

    def _pose_of(self, reference: str, watch: Watch | None) -> Array | None:
        # World pose (7,) of an object or the table, now; None of one that was never seen.
        if reference == TABLE:
            return IDENTITY
        index = self.world.spec.object_names.index(reference)
        return watch.pose_of(index) if watch else self._object_pose(self.world.objects[index])

    def _object_pose(self, body: int) -> Array:
        return np.array(sum(self.world.client.getBasePositionAndOrientation(body), ()))

    def movement(self, policy: Policy, start: Array, ticks: int) -> Array:
        """Poses (ticks, 7) of the hand in the reference's frame from its pose ``start`` (7,) there."""
        return movement(policy, start, ticks, self.settings.policy)

    def forces(self, policy: Policy, ticks: int, last: float) -> Array:
        """The gripper's command (ticks,) in newtons; without a gripper action it stays as it was."""
        if not len(policy.gripper_weights):
            return np.full(ticks, last)
        return forces(policy, ticks, self.world.robot.closing_force_limit, self.settings.policy)

    def hand_pose(self) -> Array:
        """The tool-centre point's pose (7,) in the world, now."""
        world = self.world
        state = world.client.getLinkState(world.body.number, world.body.hand, computeForwardKinematics=True)
        return compose(np.array(state[4] + state[5]), self.arm.tcp)

    def _looker(self, watch: Watch, steps: _Steps) -> _Observe:
        p, body = self.world.client, self.world.body
        joints = body.arm + body.fingers

        def look() -> None:
            positions = np.array([state[0] for state in p.getJointStates(body.number, joints)])
            objects = np.array([self._object_pose(thing) for thing in self.world.objects])
            watch.look(len(steps.joint_positions), positions, self.hand_pose(), objects)

        return look

    def _look_ticks(self, ticks: int) -> set[int]:
        # After which of so many control ticks the scene is looked at: the rest before the end is judged too,
        # and until then the tracker settles.
        s, rate = self.settings.learning, self.settings.world.control_rate
        every, often = (max(1, round(rate / r)) for r in (s.observe_rate, s.observe_rate_settling))
        rest = ticks - round(s.rest_time * rate)
        settling = range(rest, rest - round(s.observe_settling * rate) - 1, -often)
        return {*range(every, ticks, every), *(max(1, tick) for tick in settling), ticks}

    def _execute(
        self, commands: Array, steps: _Steps, limit: int | None = None, look: _Observe | None = None
    ) -> None:
        # The first row is the command before; velocities are backward differences, so they need no lookahead.
        rate = self.settings.world.control_rate
        observe = self._observer(steps)
        step = self.world.client.stepSimulation
        command = self._commander()
        left = limit if limit is not None else (len(commands) - 1) * self.control_every
        looks = self._look_ticks(len(commands) - 1) if look else set()
        for tick, (before, now) in enumerate(pairwise(commands.tolist()), start=1):
            command(now[:-1], [(b - a) * rate for a, b in zip(before[:-1], now[:-1], strict=True)], now[-1])
            for _ in range(min(self.control_every, left)):
                step()
                observe()
            left -= min(self.control_every, left)
            if look and tick in looks:
                look()

    def _commander(self) -> _Command:
        world, robot = self.world, self.world.robot
        body, arm = world.body.number, world.body.arm
        fingers = list(zip(world.body.fingers, robot.finger_open, robot.finger_closed, strict=True))
        speed, lever = robot.finger_speed / robot.finger_lever, robot.finger_lever
        p, s = world.client, self.settings.world
        limits = [p.getJointInfo(body, joint)[10] for joint in arm]
        gains = [s.position_gain] * len(arm)

        def command(positions: list[float], velocities: list[float], force: float) -> None:
            p.setJointMotorControlArray(
                body,
                arm,
                pybullet.POSITION_CONTROL,
                targetPositions=positions,
                targetVelocities=velocities,
                forces=limits,
                positionGains=gains,
            )
            strength = (force if force > 0 else robot.opening_force) * lever
            for finger, opened, closed in fingers:
                p.setJointMotorControl2(
                    body,
                    finger,
                    pybullet.POSITION_CONTROL,
                    targetPosition=closed if force > 0 else opened,
                    force=strength,
                    maxVelocity=speed,
                )

        return command

    def _observer(self, steps: _Steps) -> _Observe:
        p, body = self.world.client, self.world.body
        joints = body.arm + body.fingers
        states, pose_of, velocity_of = (
            p.getJointStates,
            p.getBasePositionAndOrientation,
            p.getBaseVelocity,
        )
        contacts, link = p.getContactPoints, p.getLinkState
        robot, hand, objects = body.number, body.hand, self.world.objects

        def observe() -> None:
            now = states(robot, joints)
            steps.joint_positions.append([j[0] for j in now])
            steps.joint_velocities.append([j[1] for j in now])
            at = link(robot, hand, computeForwardKinematics=True)
            steps.links.append(at[4] + at[5])
            for thing in objects:
                position, turn = pose_of(thing)
                steps.object_poses.append(position + turn)
                linear, angular = velocity_of(thing)
                steps.object_velocities.append(linear + angular)
                touching = contacts(robot, thing)
                steps.contact_forces.append(sum([c[9] for c in touching]) if touching else 0.0)

        steps.tcp = self.arm.tcp
        return observe


@dataclass
class _Steps:
    """Rows as physics gives them, made into arrays once at the end."""

    joint_positions: list[list[float]] = field(default_factory=list)
    joint_velocities: list[list[float]] = field(default_factory=list)
    links: list[tuple[float, ...]] = field(default_factory=list)
    object_poses: list[tuple[float, ...]] = field(default_factory=list)
    object_velocities: list[tuple[float, ...]] = field(default_factory=list)
    contact_forces: list[float] = field(default_factory=list)
    tcp: Array = field(default_factory=lambda: np.zeros(7))

    def record(
        self, start: Start, grid: tuple[float, int], option_starts: tuple[int, ...], commands: Array
    ) -> TrialRecord:
        """The trial so far, as data."""
        count, objects = len(self.joint_positions), len(start.objects)
        return TrialRecord(
            start=start,
            time_step=grid[0],
            control_every=grid[1],
            option_starts=option_starts,
            commands=commands,
            joint_positions=np.array(self.joint_positions),
            joint_velocities=np.array(self.joint_velocities),
            hand_poses=compose(np.array(self.links), self.tcp),
            object_poses=np.array(self.object_poses).reshape(count, objects, 7),
            object_velocities=np.array(self.object_velocities).reshape(count, objects, 6),
            contact_forces=np.array(self.contact_forces).reshape(count, objects),
        )
