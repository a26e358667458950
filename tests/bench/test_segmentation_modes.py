"""The paper's score, the robust one and CST on one stacking, without and with a slow spot in the carry.

Run: pytest -m bench -s tests/bench/test_segmentation_modes.py
"""

from collections import Counter
from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
from stacking import Stacking, is_right, perform

from imitate.segmentation import segment
from imitate.settings import load_settings

pytestmark = pytest.mark.bench
SEEDS = 40
NOISE = (0.0, 0.002, 0.005)
AFTER_LIFT = 0.7
"""s from the start of the carry to the slow spot."""
CLAIMS = {
    ("faithful", 0.0): "reach, carry, retreat",
    ("cst", 0.5): "more segments, the carry cut where the hand is slow",
    ("cst", 1.0): "the same",
}
"""Of the paper."""


@dataclass
class Row:
    """How often the skills were right, how many segments there were, and how often the slow spot was cut."""

    right: int = 0
    cut_when_slow: int = 0
    carries_cut: int = 0
    counts: Counter[int] | None = None


def measured(mode: str, slow: float) -> Row:
    settings, row = load_settings(overrides={"mode": mode}).segmentation, Row(counts=Counter())
    for seed in range(SEEDS):
        what = Stacking(noise=NOISE[seed % len(NOISE)], mid_pause=slow)
        demonstration, (lift, place) = perform(what, np.random.default_rng(3000 + seed))
        segments = segment(demonstration, settings)
        starts = np.array([s.start for s in segments[1:]])
        begins = lift + AFTER_LIFT
        row.right += is_right(segments, (lift, place), tolerance=0.5)
        row.carries_cut += bool(np.any((starts > lift + 0.5) & (starts < place - 0.5)))
        row.cut_when_slow += bool(slow and np.any((starts > begins - 0.1) & (starts < begins + slow + 0.1)))
        row.counts[len(segments)] += 1
    return row


def test_side_by_side(capsys):
    cases = product(("faithful", "robust", "cst"), (0.0, 0.5, 1.0))
    rows = {(mode, slow): measured(mode, slow) for mode, slow in cases}
    with capsys.disabled():
        print(f"\ntwo objects, no rest, noise 0, 2, 5 mm in turn, {SEEDS} seeds; slow: a stop in mid-carry")
        print("mode      slow   right  carry cut  cut when slow  segments            the paper says")
        for (mode, slow), row in rows.items():
            counts = ", ".join(f"{n}: {times}" for n, times in sorted(row.counts.items()))
            shares = [row.right, row.carries_cut, row.cut_when_slow]
            right, cut, when = (f"{share / SEEDS:.0%}" for share in shares)
            claim = CLAIMS.get((mode, slow), "")
            print(f"{mode:9} {slow:.1f} s {right:>6} {cut:>10} {when:>14}  {counts:18}  {claim}")
    assert rows["faithful", 0.0].right == SEEDS
    assert rows["robust", 0.0].right == SEEDS
    for slow in (0.5, 1.0):
        assert rows["cst", slow].cut_when_slow >= 0.9 * SEEDS
        assert min(rows["cst", slow].counts) >= 4
