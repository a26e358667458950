"""A scripted session: type-correct events in the order that the engine sends them, with made-up numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np

from imitate import events
from imitate.demonstration import Demonstration
from imitate.record import SceneSpec
from imitate.rgbd import Intrinsics
from imitate.settings import Settings, to_toml
from imitate.skill import Abstraction, Candidate, CostTerms, Formulation, Policy, Segment
from imitate.tui.film import Film
from imitate.tui.sighting import Cast, Sighting

REACH = Abstraction(("hand",), "blue")
CARRY = Abstraction(("hand", "blue"), "green")
RETREAT = Abstraction(("hand",), "green")
POLICY = Policy(
    reference="blue",
    duration=4.0,
    start=np.array([-0.2, -0.1, 0.3, 1, 0, 0, 0]),
    goal=np.array([0, 0, 0.1, 1, 0, 0, 0]),
    pose_weights=np.zeros((30, 7)),
    gripper_weights=np.zeros(0),
)


def demonstration() -> Demonstration:
    """Twelve seconds at 30 Hz: the hand reaches the blue block, puts it on the green one and leaves."""
    t = np.arange(361) / 30
    hand = np.tile([0.0, 0, 0, 1, 0, 0, 0], (361, 1))
    blue = np.tile([0.0, 0, 0.02, 0, 0, 0, 1], (361, 1))
    green = np.tile([0.2, 0.1, 0.025, 0, 0, 0, 1], (361, 1))
    way = np.array([[-0.2, -0.1, 0.3], [0, 0, 0.02], [0.2, 0.1, 0.07], [0.1, 0.1, 0.25]])
    for axis in range(3):
        hand[:, axis] = np.interp(t, [0, 4, 8, 12], way[:, axis])
        blue[120:241, axis] = hand[120:241, axis]
        blue[241:, axis] = way[2, axis]
    sizes = np.array([[0.04] * 3, [0.05] * 3])
    return Demonstration(t, hand, np.stack([blue, green], axis=1), ("blue", "green"), sizes)


def segments() -> tuple[Segment, ...]:
    def ranked(best: Abstraction) -> tuple[Candidate, ...]:
        others = [q for q in (REACH, CARRY, RETREAT) if q != best]
        return (Candidate(best, -3.5), Candidate(others[0], -16.75), Candidate(others[1], -48.0))

    return (
        Segment(0.0, 4.0, REACH, ranked(REACH)),
        Segment(4.0, 8.0, CARRY, ranked(CARRY)),
        Segment(8.0, 12.0, RETREAT, ranked(RETREAT)),
    )


def started(seed: int = 3) -> events.SessionStarted:
    demo = demonstration()
    scene = SceneSpec(
        "panda", np.array([-0.5, 0, 0, 0, 0, 0, 1]), demo.object_names, demo.object_sizes, np.full(2, 0.1),
        demo.objects[0], np.zeros(9),
    )  # fmt: skip
    versions = {"imitate": "0.1.0", "platform": "Linux"}
    return events.SessionStarted("stack.npz", "0" * 64, seed, to_toml(Settings()), versions, demo, scene)


def trial(
    segment: int,
    formulation: int,
    number: int,
    purpose: events.Purpose,
    update: int,
    cost: float,
    failure: str,
) -> events.TrialFinished:
    terms = CostTerms(cost - 5.25, 0.25, 5.0)
    return events.TrialFinished(
        segment, formulation, number, purpose, update, (POLICY,), terms, not failure, failure, None
    )


def attempt(
    formulation: Formulation, costs: list[float], successes: int, judged: int, cost: float
) -> Iterator[events.Event]:
    """One formulation from its start to its evaluation: an update after every fifth trial."""
    i, k = formulation.segment, formulation.index
    failure = "the block did not follow the hand"
    yield events.FormulationStarted(formulation)
    for n, total in enumerate(costs):
        yield trial(i, k, n, "explore", n // 5, total, "" if total < 20 and successes else failure)
        if n % 5 == 4:
            yield events.PolicyUpdated(i, k, n // 5 + 1, POLICY, min(costs[: n + 1]))
    yield events.Converged(i, k, len(costs) // 5, "two updates differed by less than 3")
    for n in range(judged):
        yield trial(i, k, len(costs) + n, "evaluate", len(costs) // 5, cost, "" if n < successes else failure)
    share = successes / judged
    yield events.Evaluated(
        i,
        k,
        successes,
        judged,
        round(max(0.0, share - 0.15), 2),
        round(min(1.0, share + 0.1), 2),
        share >= 0.8,
        cost,
    )


def film(number: int) -> Film:
    """A trial as it was shown, the block each time a little further off its place; the second one fails."""
    shown = demonstration()
    frames = slice(0, None, 2)
    objects = shown.objects[frames].copy()
    objects[:, 0, 1] += 0.01 * number
    count = len(objects)
    arm = np.linspace([-0.5, 0, 0.4], shown.hand[frames, :3], 5, axis=1)
    purpose: events.Purpose = "explore" if number < 4 else "evaluate"
    failure = "" if number != 1 else "blue ends 61 mm from its place relative to green"
    return Film(
        1, 0, number, purpose, not failure, failure, 12.5 + number,
        t=np.linspace(0, 12, count, dtype=np.float32),
        hand=shown.hand[frames].astype(np.float32),
        objects=objects.astype(np.float32),
        force=np.where((np.arange(count) > 60) & (np.arange(count) < 120), 20, 0).astype(np.float32),
        arm=arm.astype(np.float32),
        skills=np.zeros(count, np.int8),
    )  # fmt: skip


def sighting(frames: int = 361, begin: int = 0, lost: tuple[int, int] = (0, 0)) -> Sighting:
    """The demonstration from above; the hand is lost from frame to frame, blue is half hidden for a while."""
    shown, camera = demonstration(), Intrinsics(64, 48, 60.0, 60.0, 32.0, 24.0)
    which = slice(begin, frames)
    poses = np.concatenate([shown.hand[:, None], shown.objects], axis=1)
    confidence = np.tile([0.9, 0.75, 1.0], (361, 1))
    confidence[200:240, 1] = 0.3
    poses[slice(*lost), 0], confidence[slice(*lost), 0] = np.nan, 0
    corners = np.array([[(k >> axis & 1) - 0.5 for axis in range(3)] for k in range(8)])
    cast = Cast(
        ("hand", "blue", "green"),
        ((255, 255, 255), (255, 64, 220), (64, 220, 255)),
        blocks=np.array([corners * size for size in shown.object_sizes]),
        fingers=np.array([corners * [0.02, 0.02, 0.05] + [0, side * 0.01, -0.025] for side in (-1, 1)]),
        camera=camera,
        camera_from_table=np.array([-0.05, 0.0, 0.6, 1, 0, 0, 0]),
    )
    image = np.full((48, 64, 3), 90, np.uint8)
    image[:24] = np.linspace(40, 200, 64)[:, None].astype(np.uint8)
    _, jpeg = cv2.imencode(".jpg", image)
    openings = np.where(np.isnan(poses[:, 0, 0]), np.nan, 0.05)
    return Sighting(
        cast, begin, 361, shown.t[which], poses[which], openings[which], confidence[which],
        (jpeg.tobytes(),) * len(shown.t[which]),
    )  # fmt: skip


FAILED = "the block did not follow the hand in 20 of 20 trials: adding the gripper's force to the actions"


def session(reproduced: bool = True) -> Iterator[events.Event]:
    """Reach learned at once; carry fails, is reformulated and learned; retreat learned; reproduced."""
    cuts = segments()
    yield started()
    yield events.Segmented("robust", cuts)
    yield from attempt(
        Formulation(0, 0, REACH, ("pose",), "as segmented"), [9.0, 8.5, 8.75, 7.5, 7.25], 20, 20, 7.25
    )
    yield events.OptionLearned(0, 0, POLICY)
    flat = [41.0, 40.5, 42.0, 41.5, 40.25, 40.0, 41.0, 40.75, 40.5, 40.0]
    yield from attempt(Formulation(1, 0, CARRY, ("pose",), "as segmented"), flat, 0, 20, 40.0)
    yield events.Reformulated(1, 0, FAILED)
    falling = [41.0, 38.5, 30.25, 33.0, 24.5, 22.0, 18.5, 19.0, 15.5, 14.75]
    yield from attempt(Formulation(1, 1, CARRY, ("pose", "gripper"), FAILED), falling, 19, 20, 14.75)
    yield events.OptionLearned(1, 1, replace(POLICY, gripper_weights=np.array([900.0, 700, 500, 300, 100])))
    yield from attempt(
        Formulation(2, 0, RETREAT, ("pose",), "as segmented"), [6.0, 5.75, 6.5, 5.5, 5.5], 18, 20, 5.5
    )
    yield events.OptionLearned(2, 0, POLICY)
    successes = 18 if reproduced else 4
    for n in range(20):
        failure = "" if n < successes else "blue ended 6.1 cm from where it was shown"
        yield trial(2, 0, 25 + n, "reproduce", 1, 14.75, failure)
    yield events.Reproduced(
        successes, 20, round(successes / 20 - 0.15, 2), round(successes / 20 + 0.07, 2), reproduced
    )
    advice = "" if reproduced else (
        "Skill 2 (carry) let go too early in 16 of 20 runs. Try: imitate learn stack.npz --seed 4"
    )  # fmt: skip
    yield events.SessionFinished(reproduced, advice)
