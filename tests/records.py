"""Trial records made by hand: everything at rest, then changed as a test needs."""

from dataclasses import replace

import numpy as np

from imitate.record import Start, TrialRecord


def still(d, steps=480, every=4):
    """Everything at rest at the demonstration's end."""
    hand, objects = d.hand[-1], d.objects[-1]
    return TrialRecord(
        start=Start(np.zeros(9), objects),
        time_step=1 / 240,
        control_every=every,
        option_starts=(0,),
        commands=np.zeros((steps // every, 8)),
        joint_positions=np.zeros((steps, 9)),
        joint_velocities=np.zeros((steps, 9)),
        hand_poses=np.repeat(hand[None], steps, axis=0),
        object_poses=np.repeat(objects[None], steps, axis=0),
        object_velocities=np.zeros((steps, len(objects), 6)),
        contact_forces=np.zeros((steps, len(objects))),
    )


def done(d, steps=480, every=4):
    """The objects where they are at the demonstration's end, from where they are at its start."""
    record = still(d, steps, every)
    return replace(record, start=replace(record.start, objects=d.objects[0]))


def moved(record, index, offset):
    """The record with an object ``offset`` metres from where it was, all along."""
    poses = record.object_poses.copy()
    poses[:, index, :3] += offset
    return replace(record, object_poses=poses)


def gripping(record, forces):
    """The record with these gripper commands."""
    commands = record.commands.copy()
    commands[:, -1] = forces
    return replace(record, commands=commands)
