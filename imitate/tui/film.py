"""A trial as it is shown: a few moments a second of hand, objects, gripper and arm; or a demonstration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.events import Purpose, TrialFinished
from imitate.geometry import Array

RATE = 15
"""moments a second that are shown."""

Floats = NDArray[np.float32]
Line = Callable[[Array], Array]
"""joints (F, J) → points (F, P, 3) m of the arm's line."""


@dataclass(frozen=True)
class Film:
    """F moments of one trial; lengths in metres, in the world's frame.

    Attributes:
        segment, formulation, trial, purpose, success, failure: as in `imitate.events.TrialFinished`.
        cost: its total.
        t: (F,) seconds since its start.
        hand: (F, 7) poses.
        objects: (F, K, 7) poses.
        force: (F,) the gripper's command, N; 0 is open.
        arm: (F, P, 3) points of the arm from its base to the tool-centre point; none where the robot's files
            are not here.
        skills: (F,) which of the options run in a row acts, from 0.
    """

    segment: int
    formulation: int
    trial: int
    purpose: Purpose
    success: bool
    failure: str
    cost: float
    t: Floats
    hand: Floats
    objects: Floats
    force: Floats
    arm: Floats
    skills: NDArray[np.int8]

    @property
    def last(self) -> int:
        """Index of the last moment."""
        return len(self.t) - 1


def film_of(trial: TrialFinished, line: Line | None) -> Film | None:
    """The film of a trial; None where its steps were not recorded."""
    record = trial.record
    if record is None or not record.steps:
        return None
    every = max(1, round(1 / (RATE * record.time_step)))
    shown = np.unique(np.append(np.arange(0, record.steps, every), record.steps - 1))
    arm = line(record.joint_positions[shown]) if line else np.zeros((len(shown), 0, 3))
    skills = np.searchsorted(record.option_starts, shown, side="right") - 1
    return Film(
        trial.segment,
        trial.formulation,
        trial.trial,
        trial.purpose,
        trial.success,
        trial.failure,
        trial.cost.total,
        t=_floats((shown + 1) * record.time_step),
        hand=_floats(record.hand_poses[shown]),
        objects=_floats(record.object_poses[shown]),
        force=_floats(record.commands[shown // record.control_every, -1]),
        arm=_floats(arm),
        skills=skills.astype(np.int8),
    )


def still(hand: Array, objects: Array) -> Film:
    """A start that has not been run: the hand's pose (7,) and the objects' (K, 7)."""
    none = np.zeros((1, 0, 3))
    return Film(
        0,
        0,
        0,
        "reproduce",
        success=False,
        failure="",
        cost=0.0,
        t=_floats(np.zeros(1)),
        hand=_floats(hand[None]),
        objects=_floats(objects[None]),
        force=_floats(np.zeros(1)),
        arm=_floats(none),
        skills=np.zeros(1, np.int8),
    )


def film_shown(demonstration: Demonstration) -> Film:
    """What the hand did in every frame, poses known; closed while the opening is less than half its widest.

    Where the opening was not seen the hand is drawn open.
    """
    d = demonstration
    opening = np.full(len(d.t), np.nan) if d.opening is None else d.opening
    widest = np.nanmax(opening, initial=0.0)
    return replace(
        still(d.hand[0], d.objects[0]),
        t=_floats(d.t - d.t[0]),
        hand=_floats(d.hand),
        objects=_floats(d.objects),
        force=_floats(np.where(opening < widest / 2, 1.0, 0.0)),
        arm=_floats(np.zeros((len(d.t), 0, 3))),
        skills=np.zeros(len(d.t), np.int8),
    )


def _floats(values: NDArray[Any]) -> Floats:
    # Half the memory; the record has the doubles.
    found = np.ascontiguousarray(values, np.float32)
    found.flags.writeable = False
    return found
