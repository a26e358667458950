"""The gripper's force, from a policy's parameters."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.policy.dmp import response, rollout
from imitate.policy.force import forces
from imitate.settings import parse_settings
from imitate.skill import Policy

TICKS = 120
POSE = np.eye(7)[6]
POLICY = Policy("blue", 2.0, POSE, POSE, np.zeros((2, 6)), np.array([30.0, 5.0, -20.0, 60.0, 90.0]))


def settings(decay=0.0, stiffness=50.0, open_below=2.0):
    given = {"gripper_decay": decay, "gripper_stiffness": stiffness, "open_below": open_below}
    return parse_settings({"policy": given}).policy


@pytest.mark.parametrize("noise", [np.zeros(0), np.array([1.0, 20.0, 30.0, -10.0, 5.0])])
@pytest.mark.parametrize(("decay", "stiffness"), [(0.0, 50.0), (3.0, 30.0)])
def test_it_is_the_primitives_between_open_and_the_limit(decay, stiffness, noise):
    shape, zero = response(TICKS, 5, decay, stiffness), np.zeros(1)
    weights = POLICY.gripper_weights[:, None]
    free = rollout(shape, zero, zero, weights, noise[:, None] if len(noise) else None)[:, 0]
    found = forces(replace(POLICY, gripper_noise=noise), TICKS, 12.0, settings(decay, stiffness))
    closed = free > 2.0
    assert 0 < closed.sum() < TICKS
    np.testing.assert_allclose(found[closed], np.minimum(free[closed], 12.0))
    assert np.all(found[~closed] == 0)


def test_a_force_too_small_to_hold_is_open():
    held = forces(POLICY, TICKS, 80.0, settings(open_below=0.0))
    kept = forces(POLICY, TICKS, 80.0, settings(open_below=8.0))
    assert ((held > 0) & (held <= 8.0)).any()
    np.testing.assert_array_equal(kept, np.where(held > 8.0, held, 0.0))


def test_one_that_holds_ends_at_its_last_weight():
    squeeze = replace(POLICY, gripper_weights=np.array([0.0, 0.0, 0.0, 0.0, 30.0]))
    lost, kept = (forces(replace(squeeze, holds=holds), TICKS, 80.0, settings()) for holds in (False, True))
    assert lost[-1] < 10 < 27 < kept[-1] < 33
    shape = response(TICKS, 5, 0.0, 50.0)
    wanted = 30 * (shape.kernels[:, -1] + shape.goal)
    np.testing.assert_allclose(kept, np.where(wanted > 2.0, wanted, 0.0))


def test_noise_moves_what_is_held_to_as_weights_do():
    one = replace(POLICY, gripper_weights=np.zeros(5), holds=True)
    noisy = replace(one, gripper_noise=np.array([0.0, 0.0, 0.0, 0.0, 20.0]))
    shape = response(TICKS, 5, 0.0, 50.0)
    wanted = 20 * (shape.noise[:, -1] + shape.goal)
    np.testing.assert_allclose(forces(noisy, TICKS, 80.0, settings()), np.where(wanted > 2.0, wanted, 0.0))
