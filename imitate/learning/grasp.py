"""How a grasp went, told from a trial's record: never made, slipped, let go, or held; and what fell after."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import angle_between, relative
from imitate.learning.bodies import trajectory_of
from imitate.record import TrialRecord
from imitate.settings import Learning
from imitate.skill import Grasp, Gripping

_MOMENT = 0.1
"""s: a grip that is interrupted for less goes on, and one that lasts for less is none."""


def grasp_of(record: TrialRecord, index: int, option: int = -1) -> Grasp:
    """How the object ``index`` of a record was grasped during one of the options run in a row.

    Two fingers that both press with the force λ commanded give 2λ between robot and object; from half of
    that on it counts as gripped.
    """
    starts = (*record.option_starts, record.steps)
    option %= len(record.option_starts)
    span = slice(starts[option], starts[option + 1])
    force = np.repeat(record.commands[:, -1], record.control_every)[span]
    pressed = record.contact_forces[span, index]
    height = record.object_poses[span, index, 2]
    duration = len(force) * record.time_step
    moment = max(1, round(_MOMENT / record.time_step))
    grips = _runs((force > 0) & (pressed >= force), moment)
    if not grips:
        closed: Gripping = "missed" if np.any(force > 0) else "open"
        return Grasp(closed if np.any(pressed > 0) else "untouched", 0.0, duration, 0.0)
    end = grips[-1][1]
    kind: Gripping = "slipped" if end < len(force) and force[end] > 0 else "let go"
    if end >= len(force) - moment and force[-1] > 0:
        kind = "held"
    before = record.object_poses[max(span.start - 1, 0), index, 2]
    return Grasp(kind, end * record.time_step, duration, float(height[end - 1] - before))


def fell(
    record: TrialRecord, object_names: Sequence[str], body: str, reference: str, settings: Learning
) -> bool:
    """Whether a body, once the last option no longer gripped it, went on by more than β allows it to be off.

    Then where it ends is chance: from 7 cm up a cube ended right from 19 of 20 starts, and from 92 of 100.
    """
    grasp = grasp_of(record, object_names.index(body))
    if grasp.kind not in ("let go", "slipped"):
        return False
    left = record.option_starts[-1] + round(grasp.time / record.time_step) - 1
    frame, path = (trajectory_of(record, object_names, name) for name in (reference, body))
    then, end = relative(frame[left], path[left]), relative(frame[-1], path[-1])
    far = float(np.linalg.norm(then[:3] - end[:3])) > settings.near
    return far or bool(np.rad2deg(angle_between(then, end)) > settings.near_angle)


def _runs(mask: NDArray[np.bool_], moment: int) -> list[tuple[int, int]]:
    # (start, end) of each stretch of True, gaps of less than a moment bridged, those then shorter left out.
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    runs: list[tuple[int, int]] = []
    for start, end in edges.reshape(-1, 2).tolist():
        if runs and start - runs[-1][1] < moment:
            runs[-1] = runs[-1][0], end
        else:
            runs.append((start, end))
    return [(start, end) for start, end in runs if end - start >= moment]
