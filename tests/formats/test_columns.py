"""Packed columns give back every bit, whatever the numbers."""

from dataclasses import replace

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from recorded import STEP, record

from imitate.formats.columns import Packed, pack, pack_integral, pack_rotations, unpack
from imitate.formats.steps import Prefixes, pack_record, unpack_record
from imitate.record import Start, TrialRecord

ANY = st.integers(0, 2**64 - 1)  # as bits: NaNs with payloads, −0, subnormals and infinities too
SHAPES = st.tuples(st.integers(0, 12), st.integers(0, 3))


def doubles(shape: tuple[int, ...]) -> st.SearchStrategy[np.ndarray]:
    return arrays(np.uint64, shape, elements=ANY).map(lambda bits: bits.view(np.float64))


def assert_same_bits(a: np.ndarray, b: np.ndarray) -> None:
    assert a.shape == b.shape
    assert a.tobytes() == b.tobytes()


@given(values=SHAPES.flatmap(doubles), order=st.integers(0, 4))
def test_differences_keep_every_bit(values: np.ndarray, order: int) -> None:
    assert_same_bits(unpack(pack(values, order)), values)


@given(data=st.data(), shape=SHAPES)
def test_integrals_keep_every_bit(data: st.DataObject, shape: tuple[int, ...]) -> None:
    values, rates = data.draw(doubles(shape)), data.draw(doubles(shape))
    assert_same_bits(unpack(pack_integral(values, rates, STEP, 2), rates), values)


@given(data=st.data(), steps=st.integers(0, 6), bodies=st.integers(0, 3))
def test_rotations_keep_every_bit(data: st.DataObject, steps: int, bodies: int) -> None:
    values, rates = data.draw(doubles((steps, bodies, 4))), data.draw(doubles((steps, bodies, 3)))
    assert_same_bits(unpack(pack_rotations(values, rates, STEP, 3), rates), values)


@given(seed=st.integers(0, 2**16), surprises=st.integers(0, 12), steps=st.integers(1, 60))
def test_an_integral_with_surprises(seed: int, surprises: int, steps: int) -> None:
    rng = np.random.default_rng(seed)
    rates = rng.normal(size=(steps, 3))
    values = np.add.accumulate(rates * STEP)
    for at in rng.integers(0, values.size, surprises):
        values.ravel()[at] = rng.normal()
    assert_same_bits(unpack(pack_integral(values, rates, STEP, 2), rates), values)


@pytest.mark.parametrize("objects", [0, 1, 3])
@pytest.mark.parametrize("steps", [1, 2, 50])
def test_a_record_comes_back(steps: int, objects: int) -> None:
    written = record(steps, seed=steps, objects=objects)
    read = unpack_record(pack_record(written, (1, 2, 3)))
    for field in ("commands", *written.STATE_FIELDS):
        assert_same_bits(getattr(read, field), getattr(written, field))
    assert read.option_starts == written.option_starts
    assert read.time_step == written.time_step


def test_what_follows_from_velocities_costs_next_to_nothing() -> None:
    steps = 1000
    packed = pack_record(record(steps), (0, 0, 0))
    assert packed.joint_positions.expected == "integral"
    assert packed.object_positions.expected == "integral"
    for columns in (packed.joint_positions, packed.object_positions):
        assert len(zstandard.compress(columns.planes)) < 0.5 * steps
    raw = zstandard.compress(record(steps).object_poses[..., 3:].tobytes())
    assert len(zstandard.compress(packed.object_rotations.planes)) < len(raw) / 2


def test_a_column_that_never_changes_costs_nothing() -> None:
    values = np.tile(np.random.default_rng(0).normal(size=20), (2000, 1))
    assert len(zstandard.compress(pack(values, 1).planes)) < 600


def test_bytes_of_the_wrong_length_are_refused() -> None:
    packed = pack(np.ones((4, 2)), 1)
    with pytest.raises(ValueError, match="63 bytes for 4 × 2 numbers"):
        unpack(Packed(packed.shape, packed.expected, 0.0, packed.planes[:-1]))
    with pytest.raises(ValueError, match="unknown kind 'fourier'"):
        unpack(Packed(packed.shape, "fourier", 0.0, packed.planes))


def test_steps_in_common_are_written_once() -> None:
    first = record(40, seed=1)  # its second option starts at step 20
    changed = np.array(first.joint_positions)
    changed[20:] += 1
    second = replace(first, joint_positions=changed)
    third = replace(second, commands=first.commands + 1)
    prefixes = Prefixes()
    assert [prefixes.take(r) for r in (first, second, third)] == [(0, 0, 0), (1, 20, 0), (2, 0, 0)]
    packed = pack_record(second, (0, 0, 1), 1, 20, 0)
    assert packed.joint_positions.shape == (20, 9)
    assert packed.commands.shape == (5, 8)
    assert not packed.owns
    read = unpack_record(packed, first)
    for field in ("commands", *second.STATE_FIELDS):
        assert_same_bits(getattr(read, field), getattr(second, field))


def nudged(values: np.ndarray) -> np.ndarray:
    changed = np.array(values)
    changed.flat[0] = np.nextafter(changed.flat[0], np.inf)
    return changed


def one_thing_else(first: TrialRecord, what: str) -> TrialRecord:
    """The record with one bit of its beginning, or of how it is read, changed."""
    start = first.start
    match what:
        case "start.force":
            return replace(first, start=Start(start.joints, start.objects, start.force + 1))
        case "start.joints":
            return replace(first, start=Start(nudged(start.joints), start.objects, start.force))
        case "start.objects":
            return replace(first, start=Start(start.joints, nudged(start.objects), start.force))
        case "time_step":
            return replace(first, time_step=first.time_step * 2)
        case "control_every":
            return replace(first, control_every=2, commands=np.repeat(first.commands, 2, axis=0))
    return replace(first, **{what: nudged(getattr(first, what))})


BEGINNING = ("start.force", "start.joints", "start.objects", "time_step", "control_every", "commands")


@pytest.mark.parametrize("what", [*BEGINNING, *TrialRecord.STATE_FIELDS])
def test_steps_are_in_common_only_where_the_whole_beginning_is(what: str) -> None:
    first = record(40, seed=1)
    prefixes = Prefixes()
    prefixes.take(first)
    assert prefixes.take(one_thing_else(first, what)) == (1, 0, 0)
    assert prefixes.take(first) == (2, 20, 0)


def test_steps_up_to_the_middle_of_a_tick_are_not_in_common() -> None:
    # A command belongs to a whole tick: it cannot be cut in two.
    first = replace(record(40, seed=1), option_starts=(0, 18))
    prefixes = Prefixes()
    assert [prefixes.take(first) for _ in range(2)] == [(0, 0, 0), (1, 0, 0)]
    later = replace(first, option_starts=(0, 20, 30, 36))
    assert [prefixes.take(later)[1] for _ in range(2)] == [0, 20]


def test_the_longest_beginning_in_common_counts_and_who_had_it_first() -> None:
    first = replace(record(40, seed=1), option_starts=(0, 12, 28))
    second, third = (one_row_else(first, row) for row in (20, 30))
    prefixes = Prefixes()
    taken = [prefixes.take(r) for r in (first, second, third, second, first)]
    assert taken == [(0, 0, 0), (1, 12, 0), (2, 28, 0), (3, 28, 1), (4, 28, 0)]
    owns = [pack_record(first, (0, 0, 0), *t).owns for t in taken]
    assert owns == [True, True, False, False, False]


def one_row_else(first: TrialRecord, row: int) -> TrialRecord:
    poses = np.array(first.hand_poses)
    poses[row] += 1
    return replace(first, hand_poses=poses)


def test_a_record_is_stored_with_what_says_which_and_how() -> None:
    written = record(40, seed=3)
    packed = pack_record(written, (1, 2, 3), 7, 20, 4)
    assert (packed.segment, packed.formulation, packed.trial) == (1, 2, 3)
    assert (packed.number, packed.shared, packed.owner) == (7, 20, 4)
    assert (packed.time_step, packed.control_every, packed.option_starts) == (STEP, 4, (0, 20))
    read = unpack_record(packed)  # where what is shared is not at hand, its own steps
    assert_same_bits(read.hand_poses, written.hand_poses[20:])
    assert_same_bits(read.commands, written.commands[5:])
    assert_same_bits(read.start.joints, written.start.joints)
    assert read.control_every == 4
