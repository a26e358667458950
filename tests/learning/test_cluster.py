"""Trials on a cluster: a real scheduler and two workers, on this machine."""

import os
import signal
from functools import partial

import numpy as np
import pytest

from imitate.errors import ImitateError
from imitate.learning import cluster as module
from imitate.learning import trials
from imitate.learning.cluster import cluster
from imitate.learning.starts import perturbed_starts
from imitate.learning.trials import Task, Trials, process_pool
from imitate.settings import Settings
from imitate.world.scene import scene_of

distributed = pytest.importorskip("distributed", reason="the extra imitate[cluster] is not installed")
SETTINGS = Settings()


@pytest.fixture(scope="module")
def address():
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, host="127.0.0.1", dashboard_address=":0", protocol="tcp://"
    ) as here:
        yield here.scheduler_address


@pytest.fixture(scope="module")
def spec(short_demonstration):
    return scene_of(short_demonstration, SETTINGS.world)


@pytest.fixture(scope="module")
def tasks(spec, carry_problem):
    starts = perturbed_starts(spec, 4, np.random.SeedSequence(0), SETTINGS)
    return [Task(start, (carry_problem.imitated,)) for start in starts]


def outcomes(factory, spec, tasks):
    with Trials(factory, spec, SETTINGS) as pool:
        return list(pool.run(tasks))


@pytest.fixture(scope="module")
def expected(spec, tasks):
    return outcomes(process_pool(1), spec, tasks)


def assert_equal(got, expected):
    for a, b in zip(got, expected, strict=True):
        for field in a.record.STATE_FIELDS:
            np.testing.assert_array_equal(getattr(a.record, field), getattr(b.record, field))


def test_a_cluster_gives_the_same_trials_in_the_same_order(address, spec, tasks, expected):
    assert_equal(outcomes(cluster(address), spec, tasks), expected)


def _die_once(marker, scene, task):
    if not marker.exists():
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return _original(scene, task)


_original = trials._run_task


def test_a_worker_that_dies_costs_only_a_repeat(address, spec, tasks, expected, tmp_path, monkeypatch):
    monkeypatch.setattr(trials, "_run_task", partial(_die_once, tmp_path / "died"))
    assert_equal(outcomes(cluster(address), spec, tasks), expected)
    assert (tmp_path / "died").exists()


def test_nothing_that_answers_is_said(monkeypatch):
    monkeypatch.setattr(module, "_PATIENCE", 0.5)
    with pytest.raises(ImitateError, match=r"--cluster tcp://127.0.0.1:9: no scheduler answers there"):
        cluster("tcp://127.0.0.1:9")


def test_an_address_that_is_none_is_said(monkeypatch):
    monkeypatch.setattr(module, "_PATIENCE", 0.5)
    with pytest.raises(ImitateError, match=r"--cluster nowhere://x: no scheduler answers there"):
        cluster("nowhere://x")


def test_a_scheduler_without_workers_is_said():
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=":0") as empty,
        pytest.raises(ImitateError, match=r"the scheduler has no workers. Start some: dask worker tcp://"),
    ):
        cluster(empty.scheduler_address)


def test_a_worker_with_other_versions_is_refused(address, monkeypatch):
    monkeypatch.setattr(module, "_listed", lambda versions: versions["imitate"])
    real = module._versions
    here = iter([{**real(), "imitate": "99"}])
    monkeypatch.setattr(module, "_versions", lambda: next(here, real()))

    class Elsewhere:
        def run(self, _):
            return {"tcp://other": real()}

    with pytest.raises(ImitateError, match=r"the worker tcp://other has .*, and here it is 99"):
        module._check_workers(Elsewhere(), address)
