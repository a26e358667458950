"""Trials: the same bits from the same start and commands, whatever ran before."""

import re
from dataclasses import replace

import numpy as np
import pytest

from imitate.learning.problem import formulate
from imitate.segmentation import segment
from imitate.settings import Settings
from imitate.skill import Formulation
from imitate.world.scene import World, scene_of, shown_start
from imitate.world.trial import Simulator

SETTINGS = Settings()


@pytest.fixture(scope="module")
def carry(short_demonstration):
    """Scene, start and imitated policy (with a gripper) of the person's carry."""
    spec = scene_of(short_demonstration, SETTINGS.world)
    segments = segment(short_demonstration, SETTINGS.segmentation)
    i = next(i for i, s in enumerate(segments) if s.abstraction.carried)
    formulation = Formulation(i, 0, segments[i].abstraction, ("pose", "gripper"), "")
    problem = formulate(short_demonstration, segments, formulation, SETTINGS)
    return spec, shown_start(spec), problem.imitated


@pytest.fixture(scope="module")
def simulator(carry):
    made = Simulator(World(carry[0], SETTINGS.world), SETTINGS)
    yield made
    made.close()


def assert_same(a, b):
    for field in ("commands", *a.STATE_FIELDS):
        left, right = getattr(a, field), getattr(b, field)
        assert left.tobytes() == right.tobytes(), field


def grip(policy, newtons):
    return replace(policy, gripper_weights=np.full(len(policy.gripper_weights), newtons))


def test_a_trial_repeats_bit_for_bit_after_another_and_in_another_simulator(carry, simulator):
    spec, start, policy = carry
    first = simulator.run(start, [grip(policy, 25.0)]).record
    simulator.run(start, [policy])
    assert_same(first, simulator.run(start, [grip(policy, 25.0)]).record)
    other = Simulator(World(spec, SETTINGS.world), SETTINGS)
    assert_same(first, other.run(start, [grip(policy, 25.0)]).record)
    other.close()


def test_commands_alone_make_the_same_trial(carry, simulator):
    _, start, policy = carry
    record = simulator.run(start, [grip(policy, 25.0), policy]).record
    assert_same(record, simulator.resimulate(record))


def test_the_block_follows_only_a_hand_that_grips(carry, simulator):
    _, start, policy = carry
    held = simulator.run(start, [grip(policy, 25.0)]).record
    left = simulator.run(start, [policy]).record
    assert held.object_poses[:, 0, 2].max() > 0.1
    assert left.object_poses[:, 0, 2].max() < 0.05
    assert held.contact_forces[:, 0].max() > 5


def test_the_hand_follows_what_was_shown(carry, simulator, short_demonstration):
    _, start, policy = carry
    record = simulator.run(start, [policy]).record
    moving = round(policy.duration * SETTINGS.world.physics_rate)
    off = np.linalg.norm(record.hand_poses[moving - 1, :3] - short_demonstration.hand[-1, :3])
    assert off < 0.01


def test_without_a_gripper_action_the_last_command_is_held(carry, simulator):
    _, start, policy = carry
    alone = replace(policy, gripper_weights=np.zeros(0))
    record = simulator.run(replace(start, force=12.0), [alone]).record
    assert np.all(record.commands[:, -1] == 12.0)


def test_options_start_on_whole_ticks_and_hold_still_at_their_end(carry, simulator):
    _, start, policy = carry
    record = simulator.run(start, [policy, policy]).record
    hold = round(SETTINGS.world.settle_time * SETTINGS.world.control_rate)
    second = record.option_starts[1] // record.control_every
    assert record.option_starts[1] % record.control_every == 0
    assert np.ptp(record.commands[second - hold : second, :-1], axis=0).max() == 0
    assert record.steps == len(record.commands) * record.control_every


def test_a_pose_out_of_reach_ends_the_trial_and_is_said(carry, simulator):
    _, start, policy = carry
    goal = policy.goal.copy()
    goal[2] += 2.0
    outcome = simulator.run(start, [replace(policy, goal=goal)])
    assert "out of reach" in outcome.unreachable
    assert 0 < outcome.record.steps < policy.duration * SETTINGS.world.physics_rate


@pytest.mark.parametrize(("up", "wait"), [(0.8, 0.0), (2.0, 0.3)])
def test_nothing_is_commanded_from_the_pose_out_of_reach_on(carry, simulator, up, wait):
    _, start, policy = carry
    away = replace(policy, goal=policy.goal + np.array([0, 0, up, 0, 0, 0, 0]), wait=wait)
    outcome = simulator.run(start, [away, policy])
    said = re.fullmatch(r"out of reach (\d+\.\d\d) s into the skill: \((.*)\) m", outcome.unreachable)
    ticks = round(float(said[1]) * SETTINGS.world.control_rate)
    record = outcome.record
    assert record.option_starts == (0,)  # nor is the next policy run
    assert len(record.commands) == ticks
    assert record.steps == ticks * record.control_every
    hand = [simulator.arm.forward(simulator.world.spec.base, joints) for joints in record.commands[:, :-1]]
    x, y, z = map(float, said[2].split(", "))
    step = np.linalg.norm(np.diff([pose[:3] for pose in hand], axis=0), axis=1).max()
    assert np.linalg.norm(hand[-1][:3] - [x, y, z]) < 2 * step + SETTINGS.world.reach_tolerance


def test_where_even_the_first_pose_is_out_of_reach_one_tick_is_run(carry, simulator):
    _, start, policy = carry
    policy = replace(policy, duration=0.25)  # so short that the way there is a jump
    weights = np.zeros_like(policy.pose_weights)
    weights[:, 2] = 100.0
    outcome = simulator.run(start, [replace(policy, pose_weights=weights)])
    assert "out of reach" in outcome.unreachable
    assert 1 <= len(outcome.record.commands) < 15
    assert outcome.record.steps == 4 * len(outcome.record.commands)


def test_forces_stay_within_the_grippers(carry, simulator):
    _, _, policy = carry
    forces = simulator.forces(grip(policy, 1e4), 100, 0.0)
    assert forces.max() == simulator.world.robot.closing_force_limit
    assert simulator.forces(grip(policy, -50.0), 100, 0.0).max() == 0
