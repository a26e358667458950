"""What a trial costs and when it succeeds."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from records import done, gripping, moved, still

from imitate.geometry import angle_between, compose, from_yaw, relative, resample
from imitate.learning.problem import cost_of, failure_of, formulate, misses_of
from imitate.segmentation import segment
from imitate.settings import Settings, load_settings, parse_settings
from imitate.skill import Abstraction, Formulation, Segment
from imitate.world.scene import World, scene_of
from imitate.world.trial import Simulator

SETTINGS = Settings()
LEARNING = SETTINGS.learning


def failed(problem, record, unreachable, cost, settings):
    return failure_of(misses_of(problem, record, unreachable, cost, settings))


def carried_into(record, pose):
    """The whole record seen from elsewhere: everything moved by one rigid transform."""
    return replace(
        record,
        hand_poses=compose(pose, record.hand_poses),
        object_poses=compose(pose, record.object_poses),
    )


def test_the_shown_end_costs_nothing_and_succeeds(carry_problem, perfect):
    cost = cost_of(carry_problem, perfect, False, LEARNING)
    assert cost.total == pytest.approx(0, abs=1e-6)
    assert failed(carry_problem, perfect, "", cost, LEARNING) == ""


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3))
def test_only_poses_relative_to_the_reference_count(carry_problem, short_demonstration, x, y, yaw):
    record = moved(still(short_demonstration), 0, [0.03, 0, 0])
    elsewhere = carried_into(record, from_yaw([x, y, 0.0], yaw))
    here = cost_of(carry_problem, record, False, LEARNING).terminal
    assert cost_of(carry_problem, elsewhere, False, LEARNING).terminal == pytest.approx(here, abs=1e-6)


def test_a_flipped_quaternion_is_the_same_orientation(carry_problem, perfect):
    poses = perfect.object_poses.copy()
    poses[:, 0, 3:] *= -1
    flipped = replace(perfect, object_poses=poses)
    assert cost_of(carry_problem, flipped, False, LEARNING).terminal == pytest.approx(0, abs=1e-6)


def test_terminal_cost_is_a_hundred_a_metre(carry_problem, perfect):
    lifted = moved(perfect, 0, [0, 0, 0.05])
    assert cost_of(carry_problem, lifted, False, LEARNING).terminal == pytest.approx(5.0, rel=1e-3)


def test_a_body_off_by_more_than_two_centimetres_fails_in_words(carry_problem, perfect):
    cost = cost_of(carry_problem, perfect, False, LEARNING)
    assert failed(carry_problem, moved(perfect, 0, [0, 0, 0.019]), "", cost, LEARNING) == ""
    said = failed(carry_problem, moved(perfect, 0, [0, 0, 0.03]), "", cost, LEARNING)
    assert said == (
        "cubeA ends 30 mm and 0° from where it was shown relative to cubeB; cubeA was never touched"
    )
    (miss,) = misses_of(carry_problem, moved(perfect, 0, [0, 0, 0.03]), "", cost, LEARNING)
    assert (miss.term, miss.body, miss.grasp.kind) == ("position", "cubeA", "untouched")
    assert miss.distance == pytest.approx(0.03)
    assert miss.angle == pytest.approx(0, abs=1e-6)


def test_a_body_that_still_moves_fails(carry_problem, perfect):
    poses = perfect.object_poses.copy()
    poses[:, 0, 2] += np.linspace(0.12, 0, len(poses))
    cost = cost_of(carry_problem, perfect, False, LEARNING)
    assert failed(carry_problem, replace(perfect, object_poses=poses), "", cost, LEARNING) == (
        "cubeA is still moving"
    )


def test_each_switch_of_the_gripper_costs_five(carry_problem, perfect):
    forces = np.zeros(120)
    forces[10:60] = 20
    assert cost_of(carry_problem, gripping(perfect, forces), False, LEARNING).gripper == 10
    assert cost_of(carry_problem, gripping(perfect, np.full(120, 20.0)), False, LEARNING).gripper == 5


def test_holding_on_costs_and_fails_only_where_the_hand_is_shown_to_leave(stacking, carry_problem):
    demonstration, segments = stacking
    formulation = Formulation(0, 0, segments[0].abstraction, ("pose", "gripper"), "")
    leaving = formulate(demonstration, segments, formulation, Settings())
    held = gripping(still(demonstration), np.full(120, 20.0))
    for problem, costs in ((leaving, LEARNING.closed_end_cost), (carry_problem, 0.0)):
        free = cost_of(problem, still(demonstration), False, LEARNING).terminal
        cost = cost_of(problem, held, False, LEARNING)
        assert cost.terminal - free == pytest.approx(costs)
        assert ("still holds cubeA" in failed(problem, held, "", cost, LEARNING)) == bool(costs)


def test_a_later_skill_must_not_undo_what_was_placed(stacking):
    demonstration, segments = stacking
    formulation = Formulation(1, 0, segments[1].abstraction, ("pose",), "")
    problem = formulate(demonstration, segments, formulation, Settings())
    dragged = still(demonstration)
    poses = dragged.object_poses.copy()
    poses[:, 0, :3] += [0.1, 0, 0]
    hand = dragged.hand_poses.copy()
    hand[:, :3] += [0.1, 0, 0]
    dragged = replace(dragged, object_poses=poses, hand_poses=hand)
    cost = cost_of(problem, dragged, False, LEARNING)
    assert cost.terminal == pytest.approx(0, abs=1e-6)
    said = failed(problem, dragged, "", cost, LEARNING)
    assert said == "cubeA ends 100 mm from its place relative to cubeB"


def test_acceleration_costs_by_its_square_in_metres_and_seconds_at_each_tick(carry_problem, perfect):
    # Evenly accelerated along a slope: what differences of positions give is exact.
    t = np.arange(perfect.steps) * perfect.time_step
    hand = perfect.hand_poses.copy()
    hand[:, :3] += np.outer(t**2 / 2, [0.3, 0.0, 0.4])
    speeding = replace(perfect, hand_poses=hand)
    ticks = perfect.steps // perfect.control_every
    cost = cost_of(carry_problem, speeding, False, LEARNING)
    assert cost.acceleration == pytest.approx(LEARNING.acceleration_cost * 0.5**2 * (ticks - 2))
    # Of a row of options, only the last one's.
    second = replace(speeding, option_starts=(0, perfect.steps // 2))
    later = cost_of(carry_problem, second, False, LEARNING)
    assert later.acceleration == pytest.approx(LEARNING.acceleration_cost * 0.5**2 * (ticks / 2 - 2))


def test_a_switch_is_against_the_command_before_the_option(carry_problem, perfect):
    # Closed before the option and at its start: no switch; of the first option the start says it.
    forces = np.concatenate([np.zeros(30), np.full(90, 20.0)])
    record = gripping(perfect, forces)

    def switches(record):
        return cost_of(carry_problem, record, False, LEARNING).gripper / LEARNING.switch_cost

    begun = {30: 1, 31: 0, 60: 0}
    assert {tick: switches(replace(record, option_starts=(0, 4 * tick))) for tick in begun} == begun
    closed = gripping(perfect, np.full(120, 20.0))
    assert switches(closed) == 1
    assert switches(replace(closed, start=replace(closed.start, force=5.0))) == 0


def test_a_pose_out_of_reach_costs_a_fixed_amount(carry_problem, perfect):
    cost = cost_of(carry_problem, perfect, True, LEARNING)
    assert cost.terminal == LEARNING.unreachable_cost
    assert failed(carry_problem, perfect, "out of reach", cost, LEARNING) == "out of reach"


def test_the_faithful_judgement_is_terminal_cost_below_c(carry_problem, perfect):
    faithful = load_settings(None, {"mode": "faithful"}).learning
    for off, says in (
        (0.19, ""),
        (0.21, "terminal cost 21.0, not below C = 20; cubeA was never touched"),
    ):
        record = moved(perfect, 0, [0, 0, off])
        cost = cost_of(carry_problem, record, False, faithful)
        assert failed(carry_problem, record, "", cost, faithful) == says


@pytest.mark.parametrize("orientation", ["quaternion", "log"])
@pytest.mark.parametrize("form", ["hoffmann", "original"])
def test_the_imitated_policy_moves_as_shown_in_every_form(stacking, form, orientation):
    demonstration, segments = stacking
    settings = parse_settings({"policy": {"form": form, "orientation": orientation}})
    formulation = Formulation(0, 0, segments[0].abstraction, ("pose",), "")
    policy = formulate(demonstration, segments, formulation, settings).imitated
    simulator = Simulator(World(scene_of(demonstration, settings.world), settings.world), settings)
    ticks = round(policy.duration * settings.world.control_rate)
    path = simulator.movement(policy, policy.start, ticks)
    at = np.linspace(segments[0].start, segments[0].end, ticks)
    t = demonstration.t - demonstration.t[0]
    reference = demonstration.pose_of(segments[0].abstraction.reference)
    shown = resample(t, relative(reference, demonstration.hand), at)
    assert np.linalg.norm(path[:, :3] - shown[:, :3], axis=1).max() < 0.005
    assert np.rad2deg(angle_between(path, shown)).max() < 3
    assert np.linalg.norm(path[-1, :3] - policy.goal[:3]) < 0.002


@pytest.mark.parametrize(
    ("quarters", "symmetric", "right"), [(1, True, True), (2, True, True), (1, False, False)]
)
def test_a_symmetric_cube_may_end_turned_by_quarters(
    short_demonstration, carry_problem, perfect, quarters, symmetric, right
):
    names = ["cubeA"] if symmetric else []
    settings = load_settings(None, {"learning": {"symmetric": names}})
    problem = formulate(
        short_demonstration, _segments(short_demonstration), carry_problem.formulation, settings
    )
    poses = perfect.object_poses.copy()
    half = quarters * np.pi / 4
    poses[:, 0] = compose(poses[:, 0], [0, 0, 0, 0, 0, np.sin(half), np.cos(half)])
    turned = replace(perfect, object_poses=poses)
    cost = cost_of(problem, turned, False, settings.learning)
    assert (cost.terminal == pytest.approx(0, abs=1e-6)) == right
    assert (misses_of(problem, turned, "", cost, settings.learning) == ()) == right


def _segments(demonstration):
    return segment(demonstration, Settings().segmentation)


def test_a_carry_is_judged_by_what_it_carries_and_a_reach_by_the_hand(short_demonstration, carry_problem):
    assert set(carry_problem.shown) == {"cubeA"}
    segments = (Segment(0.0, 5.0, Abstraction(("hand", "cubeA"), "cubeB")),)
    reach = Formulation(0, 0, Abstraction(("hand",), "cubeA"), ("pose",), "")
    assert set(formulate(short_demonstration, segments, reach, Settings()).shown) == {"hand"}
    faithful = load_settings(overrides={"mode": "faithful"})
    carry = replace(reach, abstraction=segments[0].abstraction)
    assert set(formulate(short_demonstration, segments, carry, faithful).shown) == {"hand", "cubeA"}


def test_what_was_carried_by_less_than_the_tolerance_has_to_be_half_way_at_least(short_demonstration):
    d = short_demonstration
    objects = np.repeat(d.objects[:1], len(d.t), axis=0)
    objects[:, 0, 2] += np.linspace(0, 0.016, len(d.t))
    lifted = replace(d, objects=objects)
    lift = Segment(0.0, d.duration, Abstraction(("hand", "cubeA"), "table"))
    problem = formulate(
        lifted, (lift,), Formulation(0, 0, lift.abstraction, ("pose", "gripper"), ""), SETTINGS
    )
    up = done(lifted)
    assert failed(problem, up, "", cost_of(problem, up, False, LEARNING), LEARNING) == ""
    record = moved(up, 0, [0, 0, -0.009])
    cost = cost_of(problem, record, False, LEARNING)
    assert failed(problem, record, "", cost, LEARNING).startswith("cubeA ends 9 mm and 0° from")


def test_only_a_carry_that_closes_the_gripper_waits_for_the_fingers(short_demonstration):
    carry = Abstraction(("hand", "cubeA"), "cubeB")
    segments = (Segment(0.0, 5.0, carry),)

    def wait(abstraction, actions, settings=SETTINGS):
        stated = Formulation(0, 0, abstraction, actions, "")
        return formulate(short_demonstration, segments, stated, settings, closing_time=0.4).imitated.wait

    assert wait(carry, ("pose", "gripper")) == 0.4
    assert wait(carry, ("pose",)) == 0
    assert wait(Abstraction(("hand",), "cubeA"), ("pose", "gripper")) == 0
    assert wait(carry, ("pose", "gripper"), load_settings(overrides={"mode": "faithful"})) == 0


def test_what_hangs_in_the_air_at_the_end_is_held(short_demonstration):
    carry = Abstraction(("hand", "cubeA"), "cubeB")

    def holds(end, *later):
        stated = Formulation(0, 0, carry, ("pose", "gripper"), "")
        segments = (Segment(0.0, end, carry), *later)
        return formulate(short_demonstration, segments, stated, SETTINGS).imitated.holds

    assert holds(2.5)
    assert not holds(short_demonstration.duration)
    assert not holds(2.5, Segment(2.5, 5.0, Abstraction(("hand",), "cubeA")))


def test_all_that_is_still_held_is_named(carry_problem, short_demonstration):
    both = replace(carry_problem, lets_go=("cubeA", "cubeB"))
    held = gripping(still(short_demonstration), np.full(120, 20.0))
    cost = cost_of(both, held, False, LEARNING)
    assert "still holds cubeA and cubeB, which" in failed(both, held, "", cost, LEARNING)
