"""A system that starts no more processes is named, and nothing that was started is left behind."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import pytest

from imitate.errors import ImitateError
from imitate.learning.starting import starting
from imitate.learning.trials import process_pool
from imitate.session.sweep import session_pool

REFUSED = "Resource temporarily unavailable"


@pytest.fixture
def one_process(monkeypatch):
    """Of every two processes the second cannot be started."""
    start, started = multiprocessing.context.SpawnProcess.start, []

    def refuse(process):
        started.append(process)
        if len(started) % 2 == 0:
            raise BlockingIOError(11, REFUSED)
        start(process)

    monkeypatch.setattr(multiprocessing.context.SpawnProcess, "start", refuse)
    return started


@pytest.mark.parametrize("kind", ["trials", "sessions"])
def test_workers_that_cannot_be_started_are_named(one_process, kind):
    with pytest.raises(ImitateError) as refused:
        if kind == "trials":
            process_pool(2)()
        else:
            with session_pool(2)() as pool:
                pool.submit(abs, 1)
                pool.submit(abs, 1)
    assert f"the processes that run {kind} cannot be started ({REFUSED})." in str(refused.value)
    assert "ulimit -u" in str(refused.value) and "--workers 1" in str(refused.value)
    assert len(one_process) == 2
    one_process[0].join(timeout=30)
    assert not one_process[0].is_alive(), "it would wait for work, and our end for it"


def test_what_is_no_lack_of_processes_is_not_taken_for_it():
    with pytest.raises(KeyError), starting("a process"):
        raise KeyError("pose")


def test_a_pool_that_starts_is_whole():
    with process_pool(1)() as pool:
        assert isinstance(pool, ProcessPoolExecutor)
        assert pool.submit(abs, -1).result(timeout=60) == 1
