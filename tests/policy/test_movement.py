"""The hand's way in its reference's frame, from a policy's parameters and from where the hand is."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.geometry import angle_between, from_yaw
from imitate.policy.dmp import response, rollout
from imitate.policy.movement import movement
from imitate.settings import parse_settings
from imitate.skill import Policy

TICKS, KERNELS = 90, 8
SETTINGS = parse_settings({"policy": {"phase_decay": 4.0, "stiffness": 40.0}}).policy
ORIGINAL = parse_settings({"policy": {"phase_decay": 4.0, "stiffness": 40.0, "form": "original"}}).policy
START, GOAL = from_yaw([0.1, 0.2, 0.3], 0.4), from_yaw([0.3, 0.1, 0.2], -0.3)
RNG = np.random.default_rng(0)


def policy(channels: int, **changes: object) -> Policy:
    weights = RNG.normal(0, 0.02, (KERNELS, channels))
    return replace(Policy("blue", 1.5, START, GOAL, weights, np.zeros(0)), **changes)


@pytest.mark.parametrize("settings", [SETTINGS, ORIGINAL])
@pytest.mark.parametrize("channels", [6, 7])
def test_it_goes_from_where_the_hand_is_to_near_the_goal(channels, settings):
    here = from_yaw([0.0, 0.25, 0.35], 0.1)
    path = movement(policy(channels), here, TICKS, settings)
    assert path.shape == (TICKS, 7)
    np.testing.assert_allclose(path[0, :3], here[:3])
    assert angle_between(path[0], here) < 1e-7
    assert np.linalg.norm(path[-1, :3] - GOAL[:3]) < 0.02
    assert angle_between(path[-1], GOAL) < 0.05
    np.testing.assert_allclose(np.linalg.norm(path[:, 3:], axis=1), 1)


@pytest.mark.parametrize("channels", [6, 7])
def test_the_sign_of_the_hands_quaternion_does_not_matter(channels):
    p = policy(channels)
    other = START * [1, 1, 1, -1, -1, -1, -1]
    np.testing.assert_allclose(movement(p, other, TICKS, SETTINGS), movement(p, START, TICKS, SETTINGS))


@pytest.mark.parametrize(("settings", "original"), [(SETTINGS, False), (ORIGINAL, True)])
def test_its_positions_are_those_of_the_primitive_with_the_settings_numbers(settings, original):
    p = policy(6, pose_noise=RNG.normal(0, 0.02, (KERNELS, 6)))
    here = from_yaw([0.0, 0.25, 0.35], 0.1)
    shape = response(TICKS, KERNELS, 4.0, 40.0, original)
    # The original form scales by how far there is to go, over how far that was as shown.
    scale = (GOAL - here)[:3] / (GOAL - START)[:3] if original else np.ones(3)
    weights, noise = p.pose_weights[:, :3] * scale, p.pose_noise[:, :3] * scale
    wanted = rollout(shape, here[:3], GOAL[:3], weights, noise)
    path = movement(p, here, TICKS, settings)
    np.testing.assert_allclose(path[:, :3], wanted, atol=1e-12)
    without = movement(replace(p, pose_noise=np.zeros((0, 6))), here, TICKS, settings)
    assert np.abs(without - path).max() > 1e-4
