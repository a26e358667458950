"""A movement that the arm can follow, and one that is changed until it can."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.geometry import IDENTITY, angle_between, compose, from_yaw, inverse
from imitate.learning.following import Followed, follow, reachable, reshaped
from imitate.policy.movement import movement
from imitate.settings import Settings, parse_settings
from imitate.skill import Policy
from imitate.world.kinematics import Arm
from imitate.world.robot import load_robot

SETTINGS = Settings()
DOWN = np.array([0.0, 0, 0, 1, 0, 0, 0])


@pytest.fixture(scope="module")
def arm():
    made = Arm(load_robot("panda"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def home(arm):
    return np.array(arm.robot.rest)


def policy(arm, home, goal, weights=0.0):
    start = arm.forward(IDENTITY, home)
    shape = np.zeros((30, 6))
    shape[:, 0] = weights
    return Policy("block", 2.0, start, np.concatenate([goal, start[3:]]), shape, np.zeros(0))


def test_a_goal_within_reach_is_followed_to_the_end(arm, home):
    came = follow(policy(arm, home, [0.5, 0.1, 0.2]), arm, IDENTITY, home, IDENTITY, SETTINGS)
    assert came.share == 1.0
    assert came.arrived(SETTINGS.world)


@pytest.mark.parametrize("goal", [[1.5, 0, 0.3], [0.5, 0, -0.2]])
def test_one_beyond_the_arm_or_below_the_table_is_not(arm, home, goal):
    came = follow(policy(arm, home, goal), arm, IDENTITY, home, IDENTITY, SETTINGS)
    assert 0 < came.share < 1
    assert not came.arrived(SETTINGS.world)


def test_how_far_it_came_is_counted_in_poses_and_from_the_goal(arm, home):
    # Down through the table: the first pose below it is where the share ends.
    down = policy(arm, home, [0.5, 0, -0.2])
    way = movement(down, down.start, 120, SETTINGS.policy)
    came = follow(down, arm, IDENTITY, home, IDENTITY, SETTINGS)
    assert came.share == np.argmax(way[:, 2] <= -SETTINGS.world.reach_tolerance) / 120
    assert came.distance == pytest.approx(np.linalg.norm(way[-1, :3] - down.goal[:3]))
    assert came.angle == pytest.approx(angle_between(way[-1], down.goal), abs=1e-7)


def test_a_movement_is_followed_from_its_references_place(arm, home):
    there = from_yaw([0.1, -0.05, 0.02], 0.3)
    plain = policy(arm, home, [0.5, 0.1, 0.2], weights=0.1)
    placed = replace(
        plain, start=compose(inverse(there), plain.start), goal=compose(inverse(there), plain.goal)
    )
    came = follow(replace(placed, pose_weights=np.zeros((30, 6))), arm, IDENTITY, home, there, SETTINGS)
    assert came.arrived(SETTINGS.world)
    lifted = follow(placed, arm, IDENTITY, home, compose(there, [0, 0, -0.4, 0, 0, 0, 1]), SETTINGS)
    assert not lifted.arrived(SETTINGS.world)


@pytest.mark.parametrize(
    ("share", "distance", "angle", "arrived"),
    [
        (1.0, 0.009, 0.09, True),
        (0.99, 0.0, 0.0, False),
        (1.0, 0.011, 0.0, False),
        (1.0, 0.0, 0.11, False),
    ],
)
def test_arrived_is_all_of_it_followed_and_the_goal_near(share, distance, angle, arrived):
    assert Followed(share, distance, angle).arrived(SETTINGS.world) == arrived


@pytest.mark.parametrize(
    ("good", "bad"),
    [
        (Followed(0.9, 0.5, 0.5), Followed(0.1, 0.5, 0.5)),
        (Followed(0.5, 0.01, 0.5), Followed(0.5, 0.5, 0.5)),
        (Followed(0.5, 0.5, 0.01), Followed(0.5, 0.5, 0.5)),
    ],
)
def test_the_shape_goes_to_what_came_nearer(good, bad):
    # One of the first ten is better by one thing: the next candidate is about that one.
    asked = []

    def tried(candidate):
        asked.append(candidate.pose_weights[0])
        return good if len(asked) == 4 else bad

    ones = Policy("block", 2.0, DOWN, DOWN, np.ones((30, 6)), np.zeros(0))
    elite = parse_settings(
        {"learning": {"eliteness": 50.0, "first_rollouts": 10, "updates": 2, "rollouts": 5}}
    )
    assert reshaped(ones, tried, np.random.default_rng(0), elite) == (None, 15)
    np.testing.assert_allclose(asked[10], asked[3], atol=1e-6)


def test_channels_are_scaled_mostly_together_about_what_was_shown():
    asked = []

    def tried(candidate):
        asked.append(candidate.pose_weights[0])
        return Followed(0.5, 0.0, 0.0)

    ones = Policy("block", 2.0, DOWN, DOWN, np.ones((30, 6)), np.zeros(0))
    many = parse_settings({"learning": {"first_rollouts": 3000, "updates": 1}})
    reshaped(ones, tried, np.random.default_rng(0), many)
    drawn = np.array(asked)
    np.testing.assert_allclose(drawn.mean(axis=0), 1, atol=0.05)
    np.testing.assert_allclose(np.cov(drawn.T), 0.49 + 0.04 * np.eye(6), atol=0.05)


def test_what_is_reachable_is_told_from_what_is_not(arm, home):
    rng = np.random.default_rng(0)
    near, far = (np.array([x, 0, 0.1, *DOWN[3:]]) for x in (0.5, 1.2))
    assert reachable(arm, IDENTITY, home, near, rng, SETTINGS.world)
    assert not reachable(arm, IDENTITY, home, far, rng, SETTINGS.world)


def test_a_detour_beyond_reach_is_flattened_until_it_can_be_followed(arm, home):
    far = policy(arm, home, [0.5, 0.1, 0.2], weights=1.5)

    def tried(candidate):
        return follow(candidate, arm, IDENTITY, home, IDENTITY, SETTINGS)

    assert not tried(far).arrived(SETTINGS.world)
    found, trials = reshaped(far, tried, np.random.default_rng(0), SETTINGS)
    assert found is not None
    assert trials <= 30
    assert tried(found).arrived(SETTINGS.world)
    assert np.abs(found.pose_weights[:, 0]).max() < 1.5
    assert replace(found, pose_weights=far.pose_weights).duration == far.duration


def test_what_never_arrives_is_given_up_after_thirty_trials():
    asked = []

    def tried(candidate):
        asked.append(candidate)
        return Followed(0.5, 0.0, 0.0)

    hopeless = Policy("block", 2.0, DOWN, DOWN, np.ones((30, 6)), np.zeros(0))
    assert reshaped(hopeless, tried, np.random.default_rng(0), SETTINGS) == (None, 30)
    assert len(asked) == 30
