"""How a grasp went, on records made by hand and in physics."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from records import gripping, still

from imitate.geometry import compose, from_yaw
from imitate.learning.grasp import fell, grasp_of
from imitate.settings import Settings
from imitate.world.scene import World, scene_of, shown_start
from imitate.world.trial import Simulator

SETTINGS = Settings()
STEPS, EVERY = 480, 4


def trial(record, closed=(), pressed=(), force=20.0, option_starts=(0,), lifted=0.0):
    """Two seconds in which the gripper is closed and cubeA pressed during these (start, end) s."""
    commands = np.zeros(STEPS // EVERY)
    for start, end in closed:
        commands[round(start * 60) : round(end * 60)] = force
    forces = np.zeros((STEPS, 2))
    for start, end in pressed:
        forces[round(start * 240) : round(end * 240), 0] = 2 * force
    poses = record.object_poses.copy()
    poses[:, 0, 2] += np.linspace(0, lifted, STEPS)
    gripped = gripping(record, commands)
    return replace(gripped, contact_forces=forces, object_poses=poses, option_starts=option_starts)


@pytest.mark.parametrize(
    ("closed", "pressed", "words"),
    [
        ((), (), "was never touched"),
        ([(0.5, 2)], (), "was never touched"),
        ((), [(0.2, 0.3)], "was never grasped: the gripper stayed open"),
        ([(0.5, 2)], [(0.2, 0.3)], "was never grasped: the gripper closed, but not on it"),
        ([(0.5, 2)], [(0.5, 0.55)], "was never grasped: the gripper closed, but not on it"),
        ([(0.5, 2)], [(0.6, 1.2)], "slipped from the grip at 1.2 s of 2.0, 60 mm up"),
        ([(0.5, 1.5)], [(0.6, 1.5)], "was let go at 1.5 s of 2.0, 75 mm up"),
        ([(0.5, 2)], [(0.6, 2)], "was held to the end"),
        ([(0.5, 2)], [(0.6, 1), (1.05, 2)], "was held to the end"),
        ([(0.2, 0.6), (1, 2)], [(0.3, 0.6), (1.1, 1.5)], "slipped from the grip at 1.5 s of 2.0, 75 mm up"),
    ],
)
def test_grasps_are_told_apart(perfect, closed, pressed, words):
    assert str(grasp_of(trial(perfect, closed, pressed, lifted=0.1), 0)) == words


@pytest.mark.parametrize(
    ("share", "kind"), [(0.01, "missed"), (0.98, "missed"), (1.0, "held"), (1.5, "held")]
)
def test_what_is_pressed_with_less_than_half_of_what_two_fingers_give_is_not_gripped(perfect, share, kind):
    closed = trial(perfect, [(0.5, 2)], [(0.6, 2)])
    assert grasp_of(replace(closed, contact_forces=closed.contact_forces * share / 2), 0).kind == kind


def test_a_touch_is_told_from_none_at_all(perfect):
    faint = np.zeros((STEPS, 2))
    faint[100, 0] = 1e-6
    for closed, kind in ((), "open"), ([(0.5, 2)], "missed"):
        assert grasp_of(replace(trial(perfect, closed), contact_forces=faint), 0).kind == kind
        assert grasp_of(replace(trial(perfect, closed), contact_forces=faint), 1).kind == "untouched"


def test_pressing_while_the_gripper_opens_is_no_grip(perfect):
    assert grasp_of(trial(perfect, [(0.5, 1.0)], [(1.0, 1.5)]), 0).kind == "missed"


def falling(record, closed, pressed, by=(0, 0, 0), turn=0.0, body=0, at=1.75):
    """A trial in which a body jumps by metres and radians at ``at`` s."""
    gripped = trial(record, closed, pressed)
    poses = gripped.object_poses.copy()
    late = round(at * 240)
    poses[late:, body] = compose(poses[late:, body], from_yaw(by, turn))
    return replace(gripped, object_poses=poses)


@pytest.mark.parametrize(
    ("by", "turn", "words"),
    [
        ((0, 0, 0), 0.0, "lies where it was put"),
        ((0, 0, -0.019), 0.0, "sinks by less than 2 cm"),
        ((0, 0, -0.021), 0.0, "falls"),
        ((0.015, 0.015, 0), 0.0, "falls"),
        ((0, 0, 0), np.deg2rad(14), "turns by less than 15°"),
        ((0, 0, 0), np.deg2rad(16), "falls"),
    ],
)
def test_what_goes_on_after_its_release_fell(perfect, short_demonstration, by, turn, words):
    names = short_demonstration.object_names
    for closed in ([(0.5, 1.5)], [(0.5, 2)]):  # let go, and slipped
        record = falling(perfect, closed, [(0.6, 1.5)], by, turn)
        assert fell(record, names, "cubeA", "cubeB", SETTINGS.learning) == (words == "falls")


def test_what_is_held_did_not_fall_nor_what_moved_before_nor_with_the_reference(perfect, short_demonstration):
    names, far = short_demonstration.object_names, (0, 0, -0.1)
    held = falling(perfect, [(0.5, 2)], [(0.6, 2)], far)
    before = falling(perfect, [(0.5, 1.5)], [(0.6, 1.5)], far, at=1.0)
    untouched = falling(perfect, (), (), far)
    together = falling(perfect, [(0.5, 1.5)], [(0.6, 1.5)], far)
    poses = together.object_poses.copy()
    poses[420:, 1, :3] += poses[-1, 0, :3] - poses[0, 0, :3]
    together = replace(together, object_poses=poses)
    for record in (held, before, untouched, together):
        assert not fell(record, names, "cubeA", "cubeB", SETTINGS.learning)


def test_only_the_other_object_is_spoken_of(perfect):
    held = trial(perfect, [(0.5, 2)], [(0.6, 2)])
    assert grasp_of(held, 1).kind == "untouched"


def test_an_option_is_judged_by_its_own_steps(perfect):
    chained = trial(perfect, [(0, 1), (1, 2)], [(0.2, 0.9), (1, 1.5)], option_starts=(0, 240), lifted=0.1)
    last = grasp_of(chained, 0)
    assert (last.kind, last.duration) == ("slipped", 1.0)
    assert last.time == pytest.approx(0.5)
    assert last.lift == pytest.approx(0.025, abs=1e-3)
    assert grasp_of(chained, 0, 0).kind == "held"
    before = trial(perfect, [(0, 1)], [(0.2, 0.9)], option_starts=(0, 240))
    assert grasp_of(before, 0).kind == "untouched"


@given(
    st.lists(st.booleans(), min_size=12, max_size=12),
    st.lists(st.floats(0, 60), min_size=20, max_size=20),
)
def test_what_is_said_holds_of_every_record(short_demonstration, closed, forces):
    record = gripping(still(short_demonstration), 20.0 * np.repeat(closed, 10))
    pressed = np.zeros((480, 2))
    pressed[:, 0] = np.repeat(forces, 24)
    grasp = grasp_of(replace(record, contact_forces=pressed), 0)
    assert (grasp.kind == "untouched") == (not any(forces))
    assert grasp.kind not in ("slipped", "held", "let go", "missed") or any(closed)
    assert (grasp.time > 0) == (grasp.kind in ("slipped", "held", "let go"))
    assert grasp.time <= grasp.duration == 2.0


@pytest.fixture(scope="module")
def carried(short_demonstration, carry_problem):
    """Runs the imitated carry with gripper weights of these N; returns the record."""
    spec = scene_of(short_demonstration, SETTINGS.world)
    simulator = Simulator(World(spec, SETTINGS.world), SETTINGS)

    def run(*grips):
        policies = [replace(carry_problem.imitated, gripper_weights=np.array(g, float)) for g in grips]
        return simulator.run(shown_start(spec), policies).record

    yield run
    simulator.close()


def test_physics_tells_an_open_hand_from_a_grip_and_from_one_that_lets_go(carried):
    opened = carried([0.0] * 5)
    assert grasp_of(opened, 0).kind in ("untouched", "open")
    assert grasp_of(opened, 1).kind == "untouched"
    early = grasp_of(carried([30.0, 30.0, -60.0, -60.0, -60.0]), 0)
    assert early.kind == "let go"
    assert early.lift > 0.02
    assert early.time < early.duration - 0.5


def test_in_a_chain_the_last_option_counts(carried):
    # The first carries; the second moves the same way with an open hand.
    record = carried([25.0] * 5, [0.0] * 5)
    assert grasp_of(record, 0, 0).kind in ("held", "let go")
    assert grasp_of(record, 0).kind in ("untouched", "open")
