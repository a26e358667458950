"""Trials watched: beliefs come from pictures, the physics does not notice, and chance is the task's own."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.events import TrialFinished
from imitate.geometry import compose, from_yaw
from imitate.learning.problem import cost_of, misses_of
from imitate.learning.trials import Task, Trials, process_pool
from imitate.learning.watching import Watcher
from imitate.record import Sightings, as_seen
from imitate.settings import Settings, load_settings
from imitate.world.scene import World, scene_of, shown_start
from imitate.world.trial import Simulator

WATCHED = load_settings(None, {"learning": {"observe_trials": True, "observe_rate": 1.0}})


@pytest.fixture(scope="module")
def spec(short_demonstration):
    return scene_of(short_demonstration, WATCHED.world)


@pytest.fixture(scope="module")
def short(carry_problem):
    """A policy of one second on which nothing hangs but time."""
    return replace(carry_problem.imitated, duration=1.0)


def watched(spec, start, policies, seed=0, expected=None):
    simulator, watcher = Simulator(World(spec, WATCHED.world), WATCHED), Watcher(spec, WATCHED)
    watcher.begin(expected, np.random.SeedSequence(seed))
    outcome = simulator.run(start, policies, watcher)
    simulator.close()
    watcher.close()
    return replace(outcome, seen=watcher.sightings)


def apart(spec):
    """A start with both objects free of the hand and of each other, not where they were shown."""
    middle = spec.object_poses[:, :3].mean(axis=0)
    away = (middle - spec.base[:3])[:2] / np.linalg.norm((middle - spec.base[:3])[:2])
    poses = spec.object_poses.copy()
    poses[:, :2] = middle[:2] + 0.12 * away + 0.1 * np.array([[-away[1], away[0]], [away[1], -away[0]]])
    for k, yaw in enumerate((0.2, -0.2)):
        poses[k, 3:] = compose(from_yaw(np.zeros(3), yaw), poses[k])[3:]
    return replace(shown_start(spec), objects=poses)


@pytest.fixture(scope="module")
def outcome(spec, short):
    return watched(spec, apart(spec), [replace(short, reference="table", goal=spec_hand(spec))])


def spec_hand(spec):
    """Where the hand waits: a goal that it need not move for."""
    simulator = Simulator(World(spec, WATCHED.world), WATCHED)
    simulator.world.reset(shown_start(spec))
    pose = simulator.hand_pose()
    simulator.close()
    return pose


def test_objects_are_seen_where_they_are(outcome):
    seen, record = outcome.seen, outcome.record
    assert (seen.steps[0], seen.steps[-1]) == (0, record.steps)
    off = np.linalg.norm(seen.poses[..., :3] - record.object_poses[0, :, :3], axis=-1)
    assert off[-1].max() < 0.003
    assert np.any(seen.poses[-1] != record.object_poses[-1])


def test_physics_does_not_notice_that_it_is_watched(spec, outcome):
    simulator = Simulator(World(spec, WATCHED.world), WATCHED)
    again = simulator.resimulate(outcome.record)
    simulator.close()
    for field in outcome.record.STATE_FIELDS:
        assert getattr(again, field).tobytes() == getattr(outcome.record, field).tobytes()


def test_the_rest_before_the_end_is_looked_at(outcome):
    rest = round(WATCHED.learning.rest_time * WATCHED.world.physics_rate)
    assert outcome.record.steps - rest in outcome.seen.steps


def test_before_that_it_is_looked_at_often_for_the_tracker_to_settle(outcome):
    s, rate = WATCHED.learning, WATCHED.world.physics_rate
    rest = outcome.record.steps - round(s.rest_time * rate)
    begin = rest - round(s.observe_settling * rate)
    settling = [step for step in outcome.seen.steps if begin <= step <= rest]
    assert len(settling) == 1 + round(s.observe_settling * s.observe_rate_settling)
    assert max(np.diff(settling)) <= rate / s.observe_rate_settling


def test_chance_is_the_tasks_and_not_the_workers(spec, short):
    start = shown_start(spec)
    brief = replace(short, duration=0.3)
    tasks = [Task(start, (brief,), np.random.SeedSequence(seed)) for seed in (1, 2, 1)]
    with Trials(process_pool(1), spec, WATCHED) as pool:
        first, other, again = (outcome.seen.poses.tobytes() for outcome in pool.run(tasks))
    assert first == again != other


def test_a_reference_never_seen_ends_the_trial_and_is_said(spec, short):
    start = apart(spec)
    objects = start.objects.copy()
    objects[1, :3] = [5.0, 5.0, objects[1, 2]]  # far out of the picture
    outcome = watched(spec, replace(start, objects=objects), [short])
    assert outcome.unseen == "cubeB was not seen when the skill was to start"
    assert outcome.record.steps == WATCHED.world.physics_rate // WATCHED.world.control_rate
    believed = TrialFinished(
        0, 0, 0, "explore", 0, (short,), None, False, "", outcome.record, outcome.seen
    ).believed
    assert np.isfinite(believed.object_poses).all()


def test_what_was_seen_decides_and_not_what_was(carry_problem, perfect):
    """A record in which all is right, seen as if the block lay 5 cm off, and the reverse."""
    s = Settings().learning
    poses = perfect.object_poses[-1].copy()
    poses[0, 0] += 0.05
    wrong = Sightings(poses, (0, perfect.steps), np.stack([poses, poses]))
    for record, fails in ((perfect, False), (as_seen(perfect, wrong), True)):
        cost = cost_of(carry_problem, record, False, s)
        assert bool(misses_of(carry_problem, record, "", cost, s)) is fails
        assert (cost.terminal > 4) is fails
