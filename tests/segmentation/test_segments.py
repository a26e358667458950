"""Skills are found where they are: on people's demonstrations and on synthetic ones with known skills."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from stacking import RIGHT, Stacking, is_right, perform

from imitate.demonstration import Demonstration
from imitate.geometry import compose, from_yaw
from imitate.segmentation import segment
from imitate.settings import load_settings
from imitate.world.performance import perform as perform_human

ROBUST = load_settings().segmentation
FAITHFUL = load_settings(overrides={"mode": "faithful"}).segmentation


def stacking(seed: int = 0, **what) -> tuple[Demonstration, tuple[float, float]]:
    return perform(Stacking(**what), np.random.default_rng(seed))


def test_the_person_reaches_and_carries_and_the_nudge_is_no_skill(human_stack):
    reach, carry = segment(human_stack, ROBUST)
    assert str(reach.abstraction) == "⟨{hand}, cubeA⟩"
    assert str(carry.abstraction) == "⟨{hand, cubeA}, cubeB⟩"
    assert reach.start == 0
    assert reach.end == carry.start == pytest.approx(8.6, abs=0.5)
    assert carry.end == pytest.approx(human_stack.duration)


def test_the_hand_hardly_moves_from_the_grasp_to_the_lift(human_stack):
    _, carry = segment(human_stack, ROBUST)
    t = human_stack.t - human_stack.t[0]
    between = (t > carry.start) & (t < 9.0)
    assert between.any()
    assert np.max(np.ptp(human_stack.hand[between, :3], axis=0)) < 0.01


@pytest.mark.parametrize("rate", [10, 30])
@pytest.mark.parametrize("noise_level", [0, 0.004])
def test_with_a_retreat_there_are_three_skills_as_seen_by_a_slow_noisy_camera(human_stack, noise_level, rate):
    whole = perform_human(human_stack).demonstration
    rng = np.random.default_rng(8)
    k = np.searchsorted(whole.t, np.arange(whole.t[0], whole.t[-1], 1 / rate))
    hand, objects = whole.hand[k], whole.objects[k]
    hand[:, :3] += rng.normal(scale=noise_level, size=hand[:, :3].shape)
    objects[..., :3] += rng.normal(scale=noise_level, size=objects[..., :3].shape)
    seen = replace(whole, t=whole.t[k], hand=hand, objects=objects)
    reach, carry, retreat = segment(seen, ROBUST)
    assert [str(s.abstraction) for s in (reach, carry, retreat)] == [
        "⟨{hand}, cubeA⟩",
        "⟨{hand, cubeA}, cubeB⟩",
        "⟨{hand}, cubeA⟩",
    ]
    # The fingers close at 8.55 s; half a second of the rest before that may belong to the carry.
    assert 7.95 < carry.start < 9.1
    # The fingers open at 13.5 s; the hand rests until 14.1 s.
    assert 13.4 < carry.end < 14.3


@pytest.mark.parametrize("noise_level", [0, 0.002, 0.005])
@pytest.mark.parametrize("seed", range(3))
def test_the_papers_score_is_right_on_its_base_case(seed, noise_level):
    demonstration, times = stacking(seed, noise=noise_level)
    assert is_right(segment(demonstration, FAITHFUL), times, tolerance=0.5)


def test_the_papers_score_breaks_with_a_rest_and_the_robust_one_does_not():
    demonstration, times = stacking(rest=1.0)
    assert not is_right(segment(demonstration, FAITHFUL), times, tolerance=0.5)
    assert is_right(segment(demonstration, ROBUST), times, tolerance=0.5)


CELLS = {
    "base": {},
    "6 objects": {"objects": 6},
    "noise 8 mm": {"noise": 0.008},
    "noise 12 mm": {"noise": 0.012},
    "rest 2 s": {"rest": 2.0},
    "pause 3 s": {"pause": 3.0},
    "mid-carry pause 4 s": {"mid_pause": 4.0},
    "slow": {"speed": 1 / 3},
    "fast": {"speed": 3.0},
    "10 frames/s": {"rate": 10.0},
    "60 frames/s": {"rate": 60.0},
    "drift 10 mm": {"drift": 0.01},
    "hand 5 cm from a distractor": {"near": 0.05, "objects": 3, "rest": 1.0},
}


def robust_is_right(cell: str, seed: int) -> bool:
    demonstration, times = stacking(seed, **CELLS[cell])
    # Where the hand pauses, the cut may lie anywhere in the pause.
    return is_right(segment(demonstration, ROBUST), times, 0.6 + CELLS[cell].get("pause", 0))


@pytest.mark.parametrize("cell", CELLS)
def test_the_robust_score_is_right(cell):
    assert all(robust_is_right(cell, seed) for seed in range(3))


@pytest.mark.slow
@pytest.mark.parametrize("cell", CELLS)
def test_the_robust_score_is_right_in_95_of_100(cell):
    assert sum(robust_is_right(cell, 1000 + seed) for seed in range(40)) >= 38


@pytest.mark.slow
@pytest.mark.parametrize("noise_level", [0, 0.002, 0.005])
def test_the_papers_score_is_always_right_on_its_base_case(noise_level):
    for seed in range(40):
        demonstration, times = stacking(2000 + seed, noise=noise_level)
        assert is_right(segment(demonstration, FAITHFUL), times, tolerance=0.5)


@pytest.mark.parametrize("noise_level", [0, 0.003])
def test_a_carry_has_half_a_second_of_the_rests_beside_it(noise_level):
    demonstration, (lift, place) = stacking(pause=3.0, noise=noise_level)
    eager = segment(demonstration, ROBUST.model_copy(update={"rest_limit": 0.0}))[1]
    carry = segment(demonstration, ROBUST)[1]
    assert lift - 3.1 < carry.start < min(eager.start, lift - 0.45)
    assert max(eager.end, place + 0.45) < carry.end < place + 3.1


@pytest.mark.parametrize("mode", [ROBUST, FAITHFUL])
def test_segments_have_no_gaps_and_rank_their_alternatives(mode):
    demonstration, _ = stacking(noise=0.003)
    segments = segment(demonstration, mode)
    assert segments[0].start == 0
    assert segments[-1].end == pytest.approx(demonstration.duration)
    assert all(a.end == b.start for a, b in pairwise(segments))
    assert all(a.abstraction != b.abstraction for a, b in pairwise(segments))
    for s in segments:
        likelihoods = [c.log_likelihood for c in s.alternatives]
        assert likelihoods == sorted(likelihoods, reverse=True)
        assert s.abstraction == s.alternatives[0].abstraction
        assert len(s.alternatives) == (5 if mode is ROBUST else 4)
        assert not s.human


@pytest.mark.parametrize("mode", [ROBUST, FAITHFUL])
@hypothesis_settings(deadline=None, max_examples=8)
@given(
    later=st.floats(-1e3, 1e6),
    yaw=st.floats(-3.14, 3.14),
    shift=st.tuples(*[st.floats(-2, 2)] * 3),
)
def test_neither_the_clock_nor_the_frame_matters(mode, later, yaw, shift):
    demonstration, _ = stacking(seed=4, noise=0.001)
    world = from_yaw(np.array(shift), np.array(yaw))
    elsewhere = replace(
        demonstration,
        t=demonstration.t + later,
        hand=compose(world, demonstration.hand),
        objects=compose(world, demonstration.objects),
    )
    expected, found = segment(demonstration, mode), segment(elsewhere, mode)
    assert [s.abstraction for s in found] == [s.abstraction for s in expected]
    assert [s.start for s in found] == pytest.approx([s.start for s in expected], abs=0.05)


@pytest.mark.parametrize("mode", [ROBUST, FAITHFUL])
def test_the_order_of_the_objects_does_not_matter(mode):
    demonstration, _ = stacking(seed=5, objects=2, noise=0.002)
    order = [1, 0]
    turned = replace(
        demonstration,
        objects=demonstration.objects[:, order],
        object_names=tuple(demonstration.object_names[k] for k in order),
        object_sizes=demonstration.object_sizes[order],
    )
    expected, found = segment(demonstration, mode), segment(turned, mode)
    assert [(s.start, s.end, s.abstraction) for s in found] == [
        (s.start, s.end, s.abstraction) for s in expected
    ]


def test_irregular_times_are_honoured():
    demonstration, times = stacking(rate=100.0)
    rng = np.random.default_rng(6)
    kept = np.sort(rng.choice(len(demonstration.t), len(demonstration.t) // 3, replace=False))
    thinned = replace(
        demonstration,
        t=demonstration.t[kept],
        hand=demonstration.hand[kept],
        objects=demonstration.objects[kept],
    )
    assert is_right(segment(thinned, ROBUST), (times[0] - thinned.t[0], times[1] - thinned.t[0]), 0.6)


@pytest.mark.parametrize("mode", [ROBUST, FAITHFUL])
def test_two_frames_are_one_segment(mode):
    demonstration, _ = stacking()
    short = replace(
        demonstration, t=demonstration.t[:2], hand=demonstration.hand[:2], objects=demonstration.objects[:2]
    )
    (only,) = segment(short, mode)
    assert only.end == pytest.approx(1 / 30)


def test_a_single_object_is_carried_relative_to_the_table(human_stack):
    alone = replace(
        human_stack,
        objects=human_stack.objects[:, :1],
        object_names=human_stack.object_names[:1],
        object_sizes=human_stack.object_sizes[:1],
    )
    found = [str(s.abstraction) for s in segment(alone, ROBUST)]
    assert found == ["⟨{hand}, cubeA⟩", "⟨{hand, cubeA}, table⟩"]


def test_a_single_object_that_stays_is_reached():
    demonstration, (lift, _) = stacking(pause=1.0)
    before = demonstration.t < lift - 0.2
    reach = Demonstration(
        demonstration.t[before],
        demonstration.hand[before],
        demonstration.objects[before, :1],
        ("blue",),
        demonstration.object_sizes[:1],
    )
    assert [s.abstraction for s in segment(reach, ROBUST)] == [RIGHT[0]]
