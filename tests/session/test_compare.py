"""Comparison: any single bit is found, named and shown, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
import recorded
import scripted
from hypothesis import given
from hypothesis import strategies as st

from imitate.events import TrialFinished
from imitate.record import TrialRecord
from imitate.session.compare import Difference, column_names, compare_steps, first_difference, unequal

OBJECTS = ("blue", "green")
RECORD = recorded.record(steps=40)
FIELDS = {name: getattr(RECORD, name).reshape(RECORD.steps, -1).shape[1] for name in TrialRecord.STATE_FIELDS}


def flipped(record: TrialRecord, field: str, row: int, column: int, bit: int) -> TrialRecord:
    values = np.array(getattr(record, field))
    values.reshape(len(values), -1).view(np.uint64)[row, column] ^= np.uint64(1) << np.uint64(bit)
    return replace(record, **{field: values})


@given(st.sampled_from(sorted(FIELDS)), st.integers(0, 39), st.integers(0, 100), st.integers(0, 63))
def test_a_single_bit_of_the_state_is_found_where_it_is(field: str, row: int, column: int, bit: int) -> None:
    column %= FIELDS[field]
    found = compare_steps(flipped(RECORD, field, row, column, bit), RECORD, OBJECTS)
    assert (found.compared, found.divergent) == (40, 1)
    assert found.first is not None
    assert found.first.step == row
    before = sum(width for name, width in list(FIELDS.items())[: list(FIELDS).index(field)])
    assert found.first.field == column_names(RECORD, OBJECTS)[before + column]
    assert str(found.first.recorded) != str(found.first.replayed) or np.isnan(found.first.recorded)


@given(st.integers(0, 9), st.integers(0, 7), st.integers(0, 63))
def test_a_single_bit_of_a_command_is_found_at_its_step(row: int, column: int, bit: int) -> None:
    found = compare_steps(flipped(RECORD, "commands", row, column, bit), RECORD, OBJECTS)
    assert found.divergent == 1
    assert found.first is not None
    assert found.first.step == 4 * row
    assert found.first.field == ("commands[force]" if column == 7 else f"commands[joint {column}]")


def test_a_window_hides_what_is_outside_of_it() -> None:
    changed = flipped(RECORD, "hand_poses", 17, 0, 3)
    assert compare_steps(changed, RECORD, OBJECTS, window=(0, 17)).first is None
    assert compare_steps(changed, RECORD, OBJECTS, window=(18, 40)).first is None
    inside = compare_steps(changed, RECORD, OBJECTS, window=(10, 20))
    assert (inside.compared, inside.divergent) == (10, 1)


def test_missing_steps_differ() -> None:
    short = recorded.record(steps=36)
    whole = replace(short, **{f: getattr(RECORD, f)[:36] for f in FIELDS}, commands=RECORD.commands[:9])
    whole = replace(whole, start=RECORD.start, option_starts=RECORD.option_starts)
    found = compare_steps(RECORD, whole, OBJECTS)
    assert (found.compared, found.divergent) == (40, 4)
    assert found.first is not None
    assert (found.first.field, found.first.recorded, found.first.replayed) == ("steps", 40, 36)


@pytest.mark.parametrize(("atol", "differs"), [(0.0, True), (1e-12, True), (1e-8, False)])
def test_doubles_may_differ_by_what_is_allowed(atol: float, differs: bool) -> None:
    poses = RECORD.hand_poses + 1e-9
    found = compare_steps(RECORD, replace(RECORD, hand_poses=poses), OBJECTS, atol)
    assert bool(found.first) == differs


def test_numbers_that_are_none_are_equal_only_to_themselves() -> None:
    a, b = np.array([np.nan, np.inf, 0.0, 1.0]), np.array([np.nan, np.inf, -0.0, 1.0])
    assert unequal(a, b).tolist() == [False, False, True, False]
    assert unequal(a, b, 1e-9).tolist() == [False] * 4
    assert unequal(a, np.array([0.0, 1.0, 1.0, np.nan]), 1e9).tolist() == [True, True, False, True]


def test_fields_of_events_are_named() -> None:
    trial = replace(scripted.trial(1, 0, 4, "explore", 0, 20.0, "fell"), record=RECORD)
    assert first_difference(trial, trial) is None
    policy = trial.policies[0]
    weights = policy.pose_weights.copy()
    weights[1, 2] = np.nextafter(weights[1, 2], 9)
    cases: dict[str, TrialFinished] = {
        "policies[0].pose_weights[1,2]": replace(trial, policies=(replace(policy, pose_weights=weights),)),
        "policies.length": replace(trial, policies=(policy, policy)),
        "cost.gripper": replace(trial, cost=replace(trial.cost, gripper=-0.25)),
        "failure": replace(trial, failure="slipped"),
        "record": replace(trial, record=None),
        "object_poses[green].qz": replace(trial, record=flipped(RECORD, "object_poses", 12, 12, 1)),
        "record.start.force": replace(
            trial, record=replace(RECORD, start=replace(RECORD.start, force=RECORD.start.force + 1))
        ),
    }
    for field, other in cases.items():
        found = first_difference(trial, other, objects=OBJECTS)
        assert found is not None, field
        assert found.field == field


@pytest.mark.parametrize(
    ("recorded", "replayed", "shown"),
    [
        (3, 4, (3, 4)),
        (0.5, 0.25, (0.5, 0.25)),
        (True, False, ("True", "False")),
        ("let go", "slipped", ("let go", "slipped")),
        (None, 3, ("None", 3)),
        (scripted.REACH, None, ("Abstraction", "None")),
        (b"ab", b"a", ("b'ab'", "b'a'")),
        ("a" * 200, "a" * 201, ("a" * 200, "a" * 199 + "…")),
    ],
)
def test_values_are_shown_as_they_are_and_not_at_length(recorded, replayed, shown) -> None:
    found = first_difference(recorded, replayed, "value")
    assert found is not None
    assert (found.field, found.recorded, found.replayed, found.step) == ("value", *shown, None)
    assert [type(value) for value in (found.recorded, found.replayed)] == [type(value) for value in shown]
    assert first_difference(recorded, recorded, "value") is None


def test_of_a_trial_its_steps_are_named_before_what_follows_from_them() -> None:
    trial = replace(scripted.trial(1, 0, 4, "explore", 0, 20.0, "fell"), record=RECORD)
    changed = flipped(RECORD, "hand_poses", 5, 0, 1)
    other = replace(trial, success=True, failure="", cost=replace(trial.cost, terminal=1.0), record=changed)
    found = first_difference(trial, other, objects=OBJECTS)
    assert found is not None
    assert (found.field, found.step) == ("hand_poses.x", 5)


def test_parts_of_mappings_and_shapes_are_named() -> None:
    found = first_difference({"a": 1, "b": (1, 2)}, {"a": 1, "b": (1, 3)}, "versions")
    assert found == Difference("versions[b][1]", 2, 3)
    assert first_difference({"a": 1}, {"a": 1, "b": 2}, "versions") == Difference("versions.length", 1.0, 2.0)
    found = first_difference(np.zeros(2), np.zeros((1, 2)), "goal")
    assert found == Difference("goal.shape", "(2,)", "(1, 2)")
    assert first_difference(1.0, 1.0 + 1e-9, "cost", atol=1e-8) is None
    assert first_difference(np.ones((2, 2)), np.ones((2, 2)), "goal") is None


@pytest.mark.parametrize(
    ("window", "compared", "divergent"),
    [(None, 40, 4), ((30, 40), 10, 4), ((0, 38), 38, 2), ((0, 36), 36, 0), ((-5, 99), 40, 4)],
)
def test_steps_that_are_missing_count_within_the_window(window, compared: int, divergent: int) -> None:
    short = replace(RECORD, **{f: getattr(RECORD, f)[:36] for f in FIELDS}, commands=RECORD.commands[:9])
    found = compare_steps(RECORD, short, OBJECTS, window=window)
    assert (found.compared, found.divergent) == (compared, divergent)
    assert found.first == (Difference("steps", 40, 36, 36) if divergent else None)
    longer = compare_steps(short, RECORD, OBJECTS)
    assert (longer.compared, longer.divergent) == (36, 4)


def test_differing_steps_and_missing_ones_add_up_and_the_first_is_named() -> None:
    changed = flipped(flipped(RECORD, "hand_poses", 7, 2, 0), "contact_forces", 9, 0, 0)
    short = replace(changed, **{f: getattr(changed, f)[:36] for f in FIELDS}, commands=RECORD.commands[:9])
    found = compare_steps(RECORD, short, OBJECTS)
    assert (found.divergent, found.first.step, found.first.field) == (6, 7, "hand_poses.z")


@pytest.mark.parametrize(
    ("field", "value"), [("time_step", 1 / 120), ("control_every", 2), ("option_starts", (0, 24))]
)
def test_records_of_other_grids_differ_in_every_step(field: str, value: object) -> None:
    found = compare_steps(RECORD, replace(RECORD, **{field: value}), OBJECTS)
    assert (found.compared, found.divergent) == (40, 40)
    assert found.first is not None
    assert found.first.step == 0
    assert found.first.field.startswith(field)


def test_a_command_is_named_before_the_state_of_its_step() -> None:
    changed = flipped(flipped(RECORD, "commands", 2, 3, 0), "joint_positions", 8, 0, 0)
    found = compare_steps(changed, RECORD, OBJECTS)
    assert (found.divergent, found.first.step, found.first.field) == (1, 8, "commands[joint 3]")
    later = flipped(flipped(RECORD, "commands", 2, 3, 0), "joint_positions", 7, 0, 0)
    found = compare_steps(later, RECORD, OBJECTS)
    assert (found.divergent, found.first.step, found.first.field) == (2, 7, "joint_positions[0]")
