"""How often the skills are found exactly, on grids of synthetic demonstrations with known skills.

Run: pytest -m bench -s tests/bench/test_segmentation_grid.py
"""

from collections.abc import Callable

import numpy as np
import pytest
from showing import CAMERAS, TASKS, film
from stacking import Stacking, is_right, perform

from imitate.segmentation import segment
from imitate.settings import load_settings

pytestmark = pytest.mark.bench
ROBUST = load_settings().segmentation
FAITHFUL = load_settings(overrides={"mode": "faithful"}).segmentation
SEEDS = 40
ROWS = {
    "objects": (2, 3, 4, 5, 6),
    "noise": (0.0, 0.002, 0.005, 0.008, 0.012),
    "rest": (0.0, 0.5, 1.0, 2.0),
    "pause": (0.0, 1.0, 3.0),
    "mid_pause": (0.0, 2.0, 4.0),
    "speed": (1 / 3, 0.5, 2.0, 3.0),
    "rate": (10.0, 20.0, 60.0, 100.0),
    "drift": (0.0, 0.005, 0.01),
    "near": (0.05, 0.1),
}
"""ALGORITHMS section 2: one thing varies at a time, on two objects with 2 mm of noise."""
WITH = {"near": {"objects": 3, "rest": 1.0}}
LEAST = {("noise", 0.012): 0.9}


def share(right: Callable[[int], bool]) -> float:
    return sum(right(seed) for seed in range(SEEDS)) / SEEDS


def stacked(seed: int, settings, **what) -> bool:
    demonstration, times = perform(Stacking(**what), np.random.default_rng(seed))
    # Where the hand pauses, the cut may lie anywhere in the pause.
    return is_right(segment(demonstration, settings), times, 0.6 + what.get("pause", 0.0))


def test_stacking(capsys):
    shares = {
        (name, value): share(
            lambda seed, n=name, v=value: stacked(seed, ROBUST, **{"noise": 0.002, **WITH.get(n, {}), n: v})
        )
        for name, values in ROWS.items()
        for value in values
    }
    with capsys.disabled():
        print(f"\nrobust, stacking: % of {SEEDS} seeds right")
        for name, values in ROWS.items():
            print(f"{name:10}" + "".join(f"{v:8.3g}:{100 * shares[name, v]:4.0f}" for v in values))
    assert all(found >= LEAST.get(cell, 0.95) for cell, found in shares.items())


def test_other_tasks(capsys):
    def right(task: str, camera: str, seed: int) -> bool:
        rng = np.random.default_rng(seed)
        shown = TASKS[task](rng)
        found = segment(film(shown, CAMERAS[camera], rng), ROBUST)
        return tuple(str(s.abstraction) for s in found) == shown.skills

    shares = {
        (task, camera): share(lambda seed, a=task, b=camera: right(a, b, seed))
        for task in TASKS
        for camera in CAMERAS
    }
    with capsys.disabled():
        print(f"\nrobust: % of {SEEDS} seeds right, by task and camera")
        print(f"{'':24}" + "".join(f"{camera:>27}" for camera in CAMERAS))
        for task in TASKS:
            print(f"{task:24}" + "".join(f"{100 * shares[task, camera]:27.0f}" for camera in CAMERAS))
    assert all(found >= 0.95 for found in shares.values())


def test_the_papers_score_on_its_base_case(capsys):
    shares = {noise: share(lambda s, n=noise: stacked(s, FAITHFUL, noise=n)) for noise in (0, 0.002, 0.005)}
    with capsys.disabled():
        print(f"\nfaithful, two objects, no rest: {shares} right by noise (m)")
    assert all(found == 1 for found in shares.values())
