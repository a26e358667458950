"""The gripper's first weights from the hand's opening, where the camera saw it (an aid beyond the paper)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.geometry import Array
from imitate.policy.dmp import imitate
from imitate.policy.force import force_response
from imitate.settings import Learning, Settings
from imitate.skill import Policy, Segment, policy_ticks

LOW, HIGH = 5, 95
"""percentiles at which a hand is as closed and as open as it gets: a few wrong frames do not count."""


def with_opening(
    policy: Policy, demonstration: Demonstration, segment: Segment, settings: Settings
) -> Policy:
    """The policy with a force that closes while the hand was seen closed, and opens otherwise.

    While the hand waits before it moves, the gripper may close already; it opens when the movement is as far.

    Returns:
        the policy as it is where the fingers' opening was not seen to change.
    """
    wait, ticks = policy_ticks(policy, settings.world.control_rate)
    at = np.linspace(segment.start, segment.end, ticks)
    closed = seen_closed(demonstration, segment, at, settings.learning)
    if closed is None:
        return policy
    closed = np.append(closed, np.repeat(closed[-1], wait)) | np.append(np.repeat(closed[0], wait), closed)
    shape = force_response(len(closed), settings.policy.gripper_kernels, policy.holds, settings.policy)
    force = np.where(closed, settings.learning.seen_force, -settings.learning.seen_force)[:, None]
    force[0] = 0  # the gripper's movement starts from no force
    return replace(policy, gripper_weights=imitate(shape, force, np.zeros(1))[:, 0])


def seen_closed(
    demonstration: Demonstration, segment: Segment, at: Array, settings: Learning
) -> NDArray[np.bool_] | None:
    """Whether the hand was seen closed at times ``at`` (N,) of a segment, seconds since the first frame.

    It is closed while its opening is near the narrowest of the segment, which what is held sets. Near is a
    share of how far the hand opens at its widest: what is held may turn between the fingers or give way.

    Returns:
        None where the opening was not seen, or not wider elsewhere: nothing tells open from closed.
    """
    if demonstration.opening is None:
        return None
    seen = ~np.isnan(demonstration.opening)
    t, opening = (demonstration.t - demonstration.t[0])[seen], demonstration.opening[seen]
    within = opening[(t >= segment.start) & (t <= segment.end)]
    if not len(within):
        return None
    narrowest, widest = np.percentile(within, LOW), np.percentile(opening, HIGH)
    if widest - narrowest < settings.opening_range:
        return None
    return np.asarray(np.interp(at, t, opening) <= narrowest + settings.closed_share * (widest - narrowest))
