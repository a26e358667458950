"""Starts that are perturbed honestly, and trials that come back in order whoever runs them."""

import os
import signal
from concurrent.futures import Executor, Future
from functools import partial
from multiprocessing import active_children

import numpy as np
import pytest

from imitate.errors import ImitateError
from imitate.learning import trials as module
from imitate.learning.starts import perturbed_starts
from imitate.learning.trials import Task, Trials, process_pool
from imitate.settings import Settings
from imitate.world.scene import scene_of, shown_start

SETTINGS = Settings()


@pytest.fixture(scope="module")
def spec(short_demonstration):
    return scene_of(short_demonstration, SETTINGS.world)


def starts(spec, seed=0, count=30, settings=SETTINGS):
    return perturbed_starts(spec, count, np.random.SeedSequence(seed), settings)


def test_workers_start_before_there_is_a_first_task():
    before = set(active_children())
    with process_pool(2)():
        assert len(set(active_children()) - before) == 2


def test_outcomes_come_in_the_order_of_their_tasks(spec, carry_problem):
    tasks = [Task(start, (carry_problem.imitated,)) for start in starts(spec, count=4)]
    with Trials(process_pool(2), spec, SETTINGS) as pool:
        outcomes = list(pool.run(tasks))
    for task, outcome in zip(tasks, outcomes, strict=True):
        assert np.array_equal(outcome.record.start.objects, task.start.objects)


def _die_once(marker, scene, task):
    if not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return _original(scene, task)


_original = module._run_task


class _Fatal(Executor):
    """An executor whose every task breaks it."""

    def submit(self, *_, **__):
        future = Future()
        future.set_exception(module.BrokenExecutor("killed"))
        return future


def test_a_workers_death_costs_only_a_repeat(spec, carry_problem, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "_run_task", partial(_die_once, tmp_path / "dead"))
    tasks = [Task(shown_start(spec), (carry_problem.imitated,))] * 2
    with Trials(process_pool(1), spec, SETTINGS) as pool:
        first, second = pool.run(tasks)
    assert (tmp_path / "dead").exists()
    assert first.record.object_poses.tobytes() == second.record.object_poses.tobytes()


def test_workers_that_keep_dying_are_reported(spec, carry_problem):
    with (
        Trials(_Fatal, spec, SETTINGS) as pool,
        pytest.raises(ImitateError, match=r"died 4 times.*--workers 1"),
    ):
        list(pool.run([Task(shown_start(spec), (carry_problem.imitated,))]))
