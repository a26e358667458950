"""Problem: what is observed, what may be done, what it costs, and when it is solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imitate.demonstration import HAND, Demonstration
from imitate.errors import ImitateError
from imitate.geometry import Array, align_signs, angle_between, relative, resample
from imitate.learning.bodies import resting, trajectory_of
from imitate.learning.closing import with_opening
from imitate.learning.grasp import grasp_of
from imitate.learning.places import MOVED, Place, asked_for, places
from imitate.learning.support import hang_in_air
from imitate.learning.verdict import verdict
from imitate.perception.symmetry import nearest_alike
from imitate.policy.dmp import imitate, response
from imitate.policy.orientation import CHANNELS, to_channels
from imitate.record import TrialRecord
from imitate.settings import Learning, Settings
from imitate.skill import Abstraction, CostTerms, Formulation, Grasp, Miss, Policy, Segment, Term


@dataclass(frozen=True)
class Problem:
    """⟨S, A, cost⟩ of one formulation (the paper, section 5.1).

    Attributes:
        formulation: state and actions, by name.
        shown: body → pose (7,) in the reference's frame at the segment's end, of those that are judged.
        half_way: body → m, half of what it was shown to be carried; ∞ where it was not.
        imitated: the policy that follows the demonstration, gripper weights 0 or from the hand's opening.
        lets_go: what the demonstration has the hand leave next, having carried it.
        placed: where earlier skills are shown to place objects, and what is shown to stay; this one must not
            undo it.
        object_names: in the order of a record's objects.
        symmetric: object → size (3,) m of those whose turned poses that look the same are the same.
    """

    formulation: Formulation
    shown: dict[str, Array]
    half_way: dict[str, float]
    imitated: Policy
    lets_go: tuple[str, ...]
    placed: tuple[Place, ...]
    object_names: tuple[str, ...]
    symmetric: dict[str, Array]

    @property
    def judged(self) -> set[str]:
        """Every body whose pose at a trial's end is asked for."""
        return {*self.shown, self.formulation.abstraction.reference, *asked_for(self.placed)}


def formulate(
    demonstration: Demonstration,
    segments: tuple[Segment, ...],
    formulation: Formulation,
    settings: Settings,
    closing_time: float = 0.0,
) -> Problem:
    """States a segment as a problem: the demonstration in the reference's frame, at each frame.

    A reference that moves is followed; at run time its pose is taken when the option starts.

    Args:
        demonstration: in the table frame, every pose known.
        segments: as found, or as the operator decided.
        formulation: of one of them.
        settings: all of them.
        closing_time: s that the robot's fingers take to close.
    """
    segment = segments[formulation.segment]
    later = segments[formulation.segment + 1 : formulation.segment + 2]
    abstraction = formulation.abstraction
    reference = demonstration.pose_of(abstraction.reference)
    t = demonstration.t - demonstration.t[0]
    ticks = max(2, round((segment.end - segment.start) * settings.world.control_rate))
    at = np.linspace(segment.start, segment.end, ticks)

    def seen(body: str) -> Array:
        return resample(t, relative(reference, demonstration.pose_of(body)), at)

    hand = align_signs(seen(HAND))
    s = settings.policy
    shape = response(ticks, s.pose_kernels, s.phase_decay, s.stiffness, s.form == "original")
    channels = to_channels(hand, hand[-1], CHANNELS[s.orientation])
    grips = "gripper" in formulation.actions
    lets_go = tuple(b for b in abstraction.carried for n in later if b not in n.abstraction.carried)
    hanging = hang_in_air(demonstration, abstraction.carried, segment.end)
    policy = Policy(
        reference=abstraction.reference,
        duration=ticks / settings.world.control_rate,
        start=hand[0],
        goal=hand[-1],
        pose_weights=imitate(shape, channels, channels[-1]),
        gripper_weights=np.zeros(s.gripper_kernels if grips else 0),
        wait=closing_time if grips and abstraction.carried and settings.learning.wait_to_close else 0.0,
        holds=grips and settings.learning.hold_in_air and bool(set(hanging) - set(lets_go)),
    )
    if grips and settings.learning.gripper_from_opening:
        policy = with_opening(policy, demonstration, segment, settings)
    paths = {body: seen(body) for body in _judged(abstraction, settings.learning)}
    return Problem(
        formulation=formulation,
        shown={body: path[-1] for body, path in paths.items()},
        half_way={body: _half_way(path, body in abstraction.carried) for body, path in paths.items()},
        imitated=policy,
        lets_go=lets_go,
        placed=_placed(demonstration, segments, formulation, settings.learning),
        object_names=demonstration.object_names,
        symmetric={
            name: demonstration.object_sizes[k]
            for k, name in enumerate(demonstration.object_names)
            if name in settings.learning.symmetric
        },
    )


def _judged(abstraction: Abstraction, settings: Learning) -> tuple[str, ...]:
    # Whose poses at the end cost and are judged: what is carried rather than the hand that carries it.
    return abstraction.carried if abstraction.carried and settings.free_hand else abstraction.relevant


def _half_way(path: Array, carried: bool) -> float:
    # Within that of its end a body may not have been carried at all.
    distance = float(np.linalg.norm(path[-1, :3] - path[0, :3]))
    return distance / 2 if carried and distance > MOVED else np.inf


def _placed(
    demonstration: Demonstration,
    segments: tuple[Segment, ...],
    formulation: Formulation,
    settings: Learning,
) -> tuple[Place, ...]:
    # By the segments as shown: what was stated of earlier skills, or accepted, changes nothing. Where a trial
    # begins with this skill, its objects were moved before.
    by_then = places(demonstration, segments[: formulation.segment + 1], settings)
    at_last = places(demonstration, segments, settings)
    found = [p for p in by_then if p.kind == "carried"] + [p for p in at_last if p.kind == "still"]
    relevant = formulation.abstraction.relevant
    return tuple(replace(p, least=0.0, least_angle=0.0) for p in found if p.name not in relevant)


def check_durations(segments: tuple[Segment, ...], settings: Settings) -> None:
    """Raises ImitateError where a segment is too short for the policy's equations.

    Integrated in steps of Δt, a critically damped spring of stiffness α per duration T holds for αΔt/T < 4.
    """
    s = settings.policy
    stiffest = max(s.stiffness, s.gripper_stiffness)
    least = (int(stiffest / 4) + 2) / settings.world.control_rate
    for number, segment in enumerate(segments, start=1):
        if segment.end - segment.start < least:
            raise ImitateError(
                f"skill {number}, {segment.abstraction}, lasts {segment.end - segment.start:.2f} s; expected "
                f"at least {least:.2f} s. Move its boundary in the guided session (imitate tui), or show the "
                "task more slowly."
            )


def end_of(problem: Problem, record: TrialRecord, body: str) -> Array:
    """Pose (7,) of a body in the reference's frame at a trial's end.

    Of those that look the same, the one nearest to what was shown.
    """
    reference = problem.formulation.abstraction.reference
    names = problem.object_names
    pose = relative(trajectory_of(record, names, reference)[-1], trajectory_of(record, names, body)[-1])
    if body not in problem.symmetric:
        return pose
    return nearest_alike(pose, problem.symmetric[body], problem.shown[body])


def cost_of(problem: Problem, record: TrialRecord, unreachable: bool, settings: Learning) -> CostTerms:
    """What the last option of a trial cost, by term (authors' code; ALGORITHMS 5)."""
    terminal = settings.unreachable_cost if unreachable else _terminal(problem, record, settings)
    if problem.lets_go and record.commands[-1, -1] > 0:
        terminal += settings.closed_end_cost
    acceleration, switches = immediate_costs(record, settings)
    return CostTerms(terminal, float(acceleration.sum()), float(switches.sum()))


def _terminal(problem: Problem, record: TrialRecord, settings: Learning) -> float:
    total = 0.0
    for body, shown in problem.shown.items():
        pose = end_of(problem, record, body)
        pose = align_signs(pose[None], to=shown)[0]
        off = np.abs(pose - shown)
        total += settings.position_cost * off[:3].sum() + settings.turn_cost * off[3:].sum()
    return float(total)


def immediate_costs(record: TrialRecord, settings: Learning) -> tuple[Array, Array]:
    """Squared accelerations and gripper switches (C,) at each control tick of the last option."""
    every = record.control_every
    first = record.option_starts[-1]
    hand = record.hand_poses[first::every, :3]
    rate = 1 / (every * record.time_step)
    acceleration = np.zeros(len(hand))
    acceleration[1:-1] = settings.acceleration_cost * (np.diff(hand, 2, axis=0) ** 2).sum(axis=1) * rate**4
    before = record.commands[first // every - 1, -1] if first else record.start.force
    closed = np.append(before, record.commands[first // every :, -1]) > 0
    switches = settings.switch_cost * (closed[1:] != closed[:-1])
    return acceleration, switches


def misses_of(
    problem: Problem, record: TrialRecord, unreachable: str, cost: CostTerms, settings: Learning
) -> tuple[Miss, ...]:
    """Why β does not hold at a trial's end; empty when it does."""
    if unreachable:
        return (Miss("reach", unreachable),)
    if settings.judge == "cost":
        return _costly(problem, record, cost, settings)
    found = [_miss(problem, record, body, settings) for body in problem.shown]
    if closed := record.commands[-1, -1] > 0 and problem.lets_go:
        words = f"the gripper still holds {' and '.join(closed)}, which the hand is shown to leave"
        found.append(Miss("holding", words, closed[0]))
    found += verdict(problem.placed, record, problem.object_names, settings)
    return tuple(miss for miss in found if miss)


def failure_of(misses: Sequence[Miss]) -> str:
    """Why β does not hold, in words; empty when it does."""
    return "; ".join(map(str, misses))


def _costly(problem: Problem, record: TrialRecord, cost: CostTerms, settings: Learning) -> tuple[Miss, ...]:
    # The faithful β knows no bodies: of those carried, the one that is farthest off stands for the rest.
    c = settings.cost_threshold
    if cost.terminal < c:
        return ()
    words = f"terminal cost {cost.terminal:.1f}, not below C = {c:g}"
    carried = problem.formulation.abstraction.carried
    if not carried:
        return (Miss("cost", words),)
    offs = {body: _off(problem, record, body) for body in carried}
    body = max(offs, key=lambda b: offs[b])
    return (Miss("cost", words, body, *offs[body], _grasp(problem, record, body)),)


def _off(problem: Problem, record: TrialRecord, body: str) -> tuple[float, float]:
    # m and rad between where a body ends and where it was shown, in the reference's frame.
    pose, shown = end_of(problem, record, body), problem.shown[body]
    return float(np.linalg.norm(pose[:3] - shown[:3])), float(angle_between(pose, shown))


def _grasp(problem: Problem, record: TrialRecord, body: str) -> Grasp | None:
    carried = body in problem.formulation.abstraction.carried
    return grasp_of(record, problem.object_names.index(body)) if carried else None


def _miss(problem: Problem, record: TrialRecord, body: str, settings: Learning) -> Miss | None:
    off, angle = _off(problem, record, body)
    far, turned = (
        off > min(settings.near, problem.half_way.get(body, np.inf)),
        np.rad2deg(angle) > settings.near_angle,
    )
    if far or turned:
        term: Term = "position and angle" if far and turned else "position" if far else "angle"
        reference = problem.formulation.abstraction.reference
        shown_at = f"from where it was shown relative to {reference}"
        words = f"{body} ends {off * 1e3:.0f} mm and {np.rad2deg(angle):.0f}° {shown_at}"
        return Miss(term, words, body, off, angle, _grasp(problem, record, body))
    if not resting(trajectory_of(record, problem.object_names, body), record.time_step, settings):
        return Miss("moving", f"{body} is still moving", body, off, angle)
    return None
