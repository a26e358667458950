"""Pairing by time stamps: order, tolerance, each picture once, nothing kept for long."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from imitate.formats.pairing import COLOUR, DEPTH, LATE, Stamped, Tally, paired

MS = 1_000_000


def run(colours, depths, within=40, arrival=None):
    pictures = [Stamped(COLOUR, round(t * MS), t) for t in colours]
    pictures += [Stamped(DEPTH, round(t * MS), t) for t in depths]
    pictures.sort(key=arrival or (lambda one: one.time))
    tally = Tally()
    return [(c.held, d.held) for c, d in paired(pictures, within * MS, tally)], tally


def test_synchronous_streams_pair_one_to_one():
    times = [33 * k for k in range(300)]
    pairs, tally = run(times, times)
    assert pairs == list(zip(times, times, strict=True))
    assert (tally.seen, tally.paired, tally.late) == ([300, 300], 300, 0)


def test_a_picture_that_was_dropped_shifts_nothing():
    times = [33 * k for k in range(60)]
    pairs, _ = run([t for t in times if t != 330], [t for t in times if t != 660])
    assert pairs == [(t, t) for t in times if t not in (330, 660)]


def test_half_a_period_apart_with_jitter_pairs_nearly_all():
    generator = np.random.default_rng(0)
    colours = [33 * k + generator.uniform(-3, 3) for k in range(200)]
    depths = [33 * k + 16.5 + generator.uniform(-3, 3) for k in range(200)]
    pairs, _ = run(colours, depths)
    assert len(pairs) > 190


def test_streams_of_other_rates_pair_with_the_nearest():
    pairs, _ = run(range(0, 3000, 10), range(4, 3000, 100), within=8)
    assert pairs == [(t - 4, t) for t in range(4, 3000, 100)]


def test_too_far_apart_never_pairs_and_says_how_far():
    pairs, tally = run(range(0, 3000, 100), range(45, 3000, 100))
    assert pairs == []
    assert tally.nearest == 45 * MS


def test_clocks_that_differ_by_years_keep_little_waiting():
    pictures = iter([Stamped(k % 2, 33 * MS * k + (k % 2) * 10**18, k) for k in range(5000)])
    tally = Tally()
    assert list(paired(pictures, 40 * MS, tally)) == []
    assert tally.seen == [2500, 2500]
    assert tally.nearest > 10**17


def test_few_pictures_wait_even_when_stamps_hardly_advance():
    ahead = []

    def pictures():
        for k in range(4000):
            ahead.append(k)
            yield Stamped(k % 2, 1000 * (k // 2), k)

    most = 0
    for _, depth in paired(pictures(), 40 * MS, Tally()):
        most = max(most, len(ahead) - depth.held)
    assert most < 200


@given(
    st.lists(st.integers(0, 3000), max_size=60, unique=True),
    st.lists(st.integers(0, 3000), max_size=60, unique=True),
    st.integers(1, 120),
    st.randoms(use_true_random=False),
)
def test_every_pair_is_in_order_within_tolerance_and_used_once(colours, depths, within, random):
    shuffled = {}
    pairs, tally = run(
        colours, depths, within, lambda one: shuffled.setdefault(one, one.time + random.randint(0, LATE // 3))
    )
    assert all(abs(c - d) <= within for c, d in pairs)
    for one in (0, 1):
        times = [pair[one] for pair in pairs]
        assert times == sorted(set(times))
    assert tally.paired == len(pairs)
    assert tally.late == 0
    alone = set(colours) - {c for c, _ in pairs}, set(depths) - {d for _, d in pairs}
    if len(colours) == len(depths) == 1:
        assert bool(pairs) == (abs(colours[0] - depths[0]) <= within) != bool(alone[0])


@given(st.lists(st.integers(0, 20000), min_size=1, max_size=80, unique=True))
def test_what_arrives_far_too_late_is_counted(times):
    _, tally = run(times, times, arrival=lambda one: -one.time)
    spread = max(times) - min(times)
    assert (tally.late == 0) or spread > LATE / 2 / MS
    assert sum(tally.seen) == 2 * len(times)
