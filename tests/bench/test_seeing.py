"""Twenty filmed demonstrations, observed and segmented: accuracy, losses, frames a second.

Run: pytest -m bench -s tests/bench/test_seeing.py
IMITATE_FILMS=FOLDER keeps the recordings there for the next run.
"""

import os
import time
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from seeing import errors, film_to, is_right, plan

from imitate.demonstration import HAND
from imitate.perception.observe import observe

pytestmark = pytest.mark.bench
TASKS = ("stack", "box", "push", "unstack", "three")
SEEDS = range(4)
PROCESSES = 2


def test_twenty_demonstrations(tmp_path, capsys):
    folder = Path(os.environ.get("IMITATE_FILMS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    jobs = list(product(TASKS, SEEDS))
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        paths = list(pool.map(film_to, [folder] * len(jobs), *zip(*jobs, strict=True)))
    rows = defaultdict(list)
    with capsys.disabled():
        print()
        for (task, seed), path in zip(jobs, paths, strict=True):
            rows[task].append(_row(task, seed, path))
        print(
            "| task | objects mm, median / 95 % | objects °, median / 95 % | hand mm, median / 95 % "
            "| longest lost in view s | frames/s | segmented right |\n" + "| --- " * 7 + "|"
        )
        for task in TASKS:
            _print(task, rows[task])
        everything = [row for task in TASKS for row in rows[task]]
        _print("all", everything)
    mm, degrees, hand = (_joined(everything, key) for key in ("mm", "degrees", "hand"))
    assert all(row["complete"] for row in everything)
    assert np.median(mm) <= 3 and np.percentile(mm, 95) <= 8
    assert np.median(degrees) <= 2 and np.percentile(degrees, 95) <= 6
    assert np.median(hand) <= 5
    assert max(row["lost"] for row in everything) <= 0.3
    assert sum(row["right"] for row in everything) >= 19


def _row(task, seed, path):
    planned = plan(task, seed)
    began = time.perf_counter()
    try:
        seen = observe(path, seed=seed)
    except Exception as error:
        print(f"{task}-{seed}: {error}")
        return {
            "mm": [],
            "degrees": [],
            "hand": [],
            "lost": np.inf,
            "rate": 0,
            "right": False,
            "complete": False,
        }
    rate = len(seen.demonstration.t) / (time.perf_counter() - began)
    found = errors(planned, seen)
    objects = [e for name, e in found.items() if name != HAND]
    right, words = is_right(planned, seen.demonstration)
    names = set(planned.performance.demonstration.object_names)
    row = {
        "mm": 1000 * np.concatenate([e.away for e in objects]) if objects else [],
        "degrees": np.concatenate([e.turned for e in objects]) if objects else [],
        "hand": 1000 * found[HAND].away,
        "lost": max(e.lost for e in found.values()),
        "rate": rate,
        "right": right,
        "complete": names == set(seen.demonstration.object_names),
    }
    each = ", ".join(
        f"{name} {1000 * np.median(e.away):.1f}/{1000 * np.percentile(e.away, 95):.1f} mm "
        f"{np.median(e.turned):.1f}/{np.percentile(e.turned, 95):.1f}° {e.lost:.1f} s"
        for name, e in found.items()
    )
    print(f"{task}-{seed}: {each}, {rate:.0f} frames/s, {'right' if right else 'wrong'}: {words}")
    if not row["complete"]:
        print(f"    found {sorted(seen.demonstration.object_names)} instead of {sorted(names)}")
    return row


def _joined(rows, key):
    return np.concatenate([row[key] for row in rows])


def _print(task, rows):
    pairs = []
    for key in ("mm", "degrees", "hand"):
        values = _joined(rows, key)
        pairs.append(f"{np.median(values):.1f} / {np.percentile(values, 95):.1f}" if len(values) else "–")
    rate = np.median([row["rate"] for row in rows])
    print(
        f"| {task} | {' | '.join(pairs)} | {max(row['lost'] for row in rows):.2f} | {rate:.0f} "
        f"| {sum(row['right'] for row in rows)} of {len(rows)} |"
    )
