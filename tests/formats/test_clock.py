"""Stamps that leave their clock, units of times, and whose clock holds for a file."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.formats.clock import (
    AHEAD,
    astray_note,
    epoch_unit,
    faster_unit,
    gaps_in_words,
    on_one_clock,
    whose_clock,
)

T = np.arange(0, 6, 0.1)


def kept(times, second=1.0):
    off = []
    return list(on_one_clock(times, lambda one: one, off.append, second)), off


@pytest.mark.parametrize("by", [-30, 30, -1.5, 1e9, -1e9])
@pytest.mark.parametrize("at", [0, 1, 30, len(T) - 2, len(T) - 1])
def test_one_stamp_that_is_off_is_left_out_wherever_it_stands(at, by):
    times = T.tolist()
    times[at] += by
    assert kept(times) == ([t for k, t in enumerate(times) if k != at], [times[at]])


def test_three_stamps_in_a_row_are_off():
    times = (T + 1.7e9).tolist()
    times[20:23] = [0, 0, 0]
    assert kept(times) == (times[:20] + times[23:], [0, 0, 0])


@pytest.mark.parametrize("by", [-30, 30, 1e9])
def test_a_clock_that_is_set_is_left(by):
    times = np.where(T > 3, T + by, T).tolist()
    assert kept(times) == (times, [])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=40), st.floats(-1e9, 1e9))
def test_times_that_never_jump_are_all_kept(steps, begin):
    times = [begin, *(begin + np.cumsum(steps)).tolist()]
    assert kept(times) == (times, [])


@pytest.mark.parametrize("step", [2.0, 5.0, 50.0])
def test_few_frames_a_second_are_no_jumps(step):
    times = (step * np.arange(20)).tolist()
    assert kept(times) == (times, [])


def test_a_pause_is_left_and_nanoseconds_count_as_such():
    times = [0, 10**8, 2 * 10**8, 40 * 10**9, 40 * 10**9 + 10**8, 40 * 10**9 + 2 * 10**8]
    assert kept(times, 10**9) == (times, [])


def test_few_samples_are_read_ahead():
    read = []
    source = (read.append(t) or t for t in T)
    next(on_one_clock(source, lambda one: one, print))
    assert len(read) == AHEAD + 1


@pytest.mark.parametrize(
    ("ticks", "unit"),
    [
        (T, None),
        (T + 1.7e9, "s"),
        (1e3 * (T + 1.7e9), "ms"),
        (1e6 * (T + 1.7e9), "us"),
        (1e9 * (T + 1.7e9), "ns"),
        (1e6 * T + 2e9, None),  # of a machine that has run for half an hour
        (1e9 * T + 1.5e12, None),
    ],
)
def test_what_counts_since_1970_is_known_by_its_size_and_its_steps(ticks, unit):
    assert epoch_unit(ticks) == unit


@pytest.mark.parametrize(("step", "unit"), [(1, "ms"), (33, "ms"), (33_333, "us"), (33_333_333, "ns")])
def test_the_unit_that_makes_a_usual_rate(step, unit):
    assert faster_unit(step) == unit


STAMPED = [(1000 * 10**9 + k, 2000 * 10**9 + k) for k in range(9)]


@pytest.mark.parametrize(
    ("streams", "clock", "why"),
    [
        ({"/a": STAMPED, "/b": STAMPED}, 0, None),
        ({"/a": STAMPED, "/b": [(0, t) for _, t in STAMPED]}, 1, "/b has no stamps"),
        ({"/a": [(0, t) for _, t in STAMPED], "/b": [(0, 5)]}, 1, "/a, /b have no stamps"),
        ({"/a": [(0, 7), *STAMPED], "/b": STAMPED}, 0, None),  # one is missing: it is off, not the clock
        (
            {"/a": STAMPED, "/b": [(10**9, STAMPED[0][1])]},
            1,
            "/a, /b are stamped by two clocks, 16.7 minutes apart",
        ),
        ({"/a": STAMPED, "/b": [(10**9, 10**9)]}, 0, None),  # nor does the log know better
        ({"/a": STAMPED, "/b": []}, 0, None),
    ],
)
def test_one_clock_for_a_file(streams, clock, why):
    notes = []
    assert whose_clock(streams, notes) == clock
    assert notes == ([f"{why}: the log's times are used"] if why else [])
    whose_clock(streams, notes)
    assert len(notes) <= 1


def test_gaps_are_named():
    assert gaps_in_words(T) == gaps_in_words(5 * T) == gaps_in_words(T[:1]) == []
    (note,) = gaps_in_words(np.concatenate([T, T + 40, T + 60]))
    assert note == (
        "34.1 s pass without a frame, from 5.9 s on, the longest of 2 such gaps: taken as one straight "
        "motion. Where it was a pause, cut it out"
    )


def test_what_is_left_out_is_counted():
    assert astray_note("clouds", 1, 9) == (
        "1 of 9 clouds is left out: stamped more than 1 s off those before and after"
    )
    assert astray_note("clouds", 2, 9).startswith("2 of 9 clouds are left out")
