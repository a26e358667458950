"""People's demonstrations and those of an independent simulator's experts: each skill and its reference."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imitate.demonstration import Demonstration
from imitate.formats.demonstrations import read_demonstration
from imitate.geometry import compose, resample
from imitate.segmentation import segment
from imitate.settings import load_settings

ROBUST = load_settings().segmentation
REAL = Path(__file__).parents[2] / ".." / "shared" / "data" / "demonstrations"

RIGHT = {
    "human_SawyerStack_demo_1": ["⟨{hand}, cubeA⟩", "⟨{hand, cubeA}, cubeB⟩"],
    "human_SawyerLift_demo_1": ["⟨{hand}, cube⟩", "⟨{hand, cube}, table⟩"],
    "human_SawyerPickPlace_demo_1": [
        skill
        for thing in ("Can", "Cereal", "Milk", "Bread")
        for skill in (f"⟨{{hand}}, {thing}0⟩", f"⟨{{hand, {thing}0}}, goal_{thing}⟩")
    ],
    "human101_Door_demo_1": ["⟨{hand}, door_handle⟩", "⟨{hand, door_handle}, frame⟩"],
    "expert_assembly_s0": ["⟨{hand}, RoundNut⟩", "⟨{hand, RoundNut}, peg⟩"],
    "expert_bin-picking_s0_slow4": ["⟨{hand}, obj⟩", "⟨{hand, obj}, binB⟩"],
    "expert_drawer-open_s0_slow4": ["⟨{hand}, drawer_link⟩", "⟨{hand, drawer_link}, drawer⟩"],
    "expert_hammer_s0": ["⟨{hand}, hammerbody⟩", "⟨{hand, hammerbody}, nail_link⟩"],
    "expert_pick-place_s0": ["⟨{hand}, obj⟩", "⟨{hand, obj}, table⟩"],
}


def shown(name: str) -> Demonstration:
    path = REAL / f"{name}.npz"
    if not path.exists():
        pytest.skip("the shared demonstrations are not beside the project")
    return read_demonstration(path)


def skills(demonstration: Demonstration) -> list[str]:
    return [str(s.abstraction) for s in segment(demonstration, ROBUST)]


def at(demonstration: Demonstration, t: np.ndarray) -> Demonstration:
    d = demonstration
    return replace(d, t=t, hand=resample(d.t, d.hand, t), objects=resample(d.t, d.objects, t))


@pytest.mark.parametrize("name", RIGHT)
def test_each_skill_is_found_and_named(name):
    assert skills(shown(name)) == RIGHT[name]


def test_the_nudge_in_the_persons_stacking_is_no_skill():
    _, carry = segment(shown("human_SawyerStack_demo_1"), ROBUST)
    assert carry.start == pytest.approx(8.6, abs=0.5)


@pytest.mark.parametrize(
    "name", ["human_SawyerStack_demo_1", "human101_Door_demo_1", "human_SawyerLift_demo_1"]
)
@pytest.mark.parametrize("rate", [10, 60])
def test_the_frame_rate_does_not_matter(name, rate):
    d = shown(name)
    other = at(d, np.arange(d.t[0], d.t[-1], 1 / rate))
    assert skills(other) == RIGHT[name]
    moved = np.subtract([s.start for s in segment(other, ROBUST)], [s.start for s in segment(d, ROBUST)])
    assert np.abs(moved).max() < 0.3


@pytest.mark.parametrize("name", ["human_SawyerStack_demo_1", "human101_Door_demo_1"])
def test_a_camera_that_loses_what_it_sees_still_sees_the_skills(name):
    d = shown(name)
    rng = np.random.default_rng(11)
    objects = d.objects.copy()
    for start in rng.uniform(0, d.duration, 12):
        gone = (d.t - d.t[0] > start) & (d.t - d.t[0] < start + 0.3)
        objects[gone, rng.integers(objects.shape[1])] = np.nan
    assert skills(replace(d, objects=objects)) == RIGHT[name]


@pytest.mark.parametrize("name", ["human_SawyerStack_demo_1", "human101_Door_demo_1"])
@pytest.mark.parametrize("axis", range(3))
def test_it_does_not_matter_where_on_a_body_its_origin_lies(name, axis):
    d = shown(name)
    offset = np.append(0.15 * np.eye(3)[axis], [0.0, 0, 0, 1])
    moved = np.concatenate([compose(d.objects[:, :1], offset), d.objects[:, 1:]], axis=1)
    assert skills(replace(d, objects=moved, object_sizes=d.object_sizes * np.nan)) == RIGHT[name]
