"""Trials in parallel, on any executor, given back in the order asked for."""

from __future__ import annotations

import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing import get_context, parent_process
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from imitate.errors import ImitateError
from imitate.geometry import Array
from imitate.learning.starting import starting
from imitate.record import SceneSpec, Start
from imitate.settings import Settings
from imitate.skill import Policy
from imitate.world.scene import World
from imitate.world.trial import Outcome, Simulator

if TYPE_CHECKING:
    from imitate.learning.watching import Watcher

ExecutorFactory = Callable[[], Executor]

WATCHING = 0x5EE
"""spawn key of what is drawn while trials are watched."""

_DEATHS_FORGIVEN = 3
_ONE_AT_A_TIME = threading.Lock()  # a cluster's worker may have several threads, and a world is one


@dataclass(frozen=True)
class Task:
    """One trial to run.

    Attributes:
        start: where it starts.
        policies: those run in a row.
        seed: of what chance there is in watching it.
        expected: (K, 7) where the objects were seen before, if they were; else they are looked for.
    """

    start: Start
    policies: tuple[Policy, ...]
    seed: np.random.SeedSequence = field(default_factory=lambda: np.random.SeedSequence(0))
    expected: Array | None = None


def process_pool(workers: int) -> ExecutorFactory:
    """A factory of local process pools; a spawned process inherits nothing but what it is sent."""
    return partial(_pool, workers)


def _pool(workers: int) -> ProcessPoolExecutor:
    with starting("the processes that run trials"):
        pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_end_with_parent)
        for _ in range(workers):
            pool.submit(_import_all)  # a second's work, while whoever made the pool prepares the first task
    return pool


def _import_all() -> None:
    """Nothing: to have it, a worker has imported this module and all that trials need."""


def _end_with_parent() -> None:
    # A worker whose parent was killed would wait for its next task for ever; Ctrl-C is the parent's affair.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()

    def wait() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


class _Here(Executor):
    """This process itself: each task is run when its outcome is asked for."""

    def map(self, fn: Callable[..., Any], *iterables: Iterable[Any], **_: Any) -> Iterator[Any]:
        return map(fn, *iterables)


Skip = Callable[[int, int], bool]
"""skip(segment, formulation): whether the operator gives it up; asked after each batch of its trials."""


def nothing_is_skipped(_segment: int, _formulation: int) -> bool:
    """As where no operator watches."""
    return False


class Trials:
    """Runs tasks of one scene as long as the operator wants them; use as a context manager.

    After one worker's death a process pool refuses every later task, so a new executor is made and what was
    not finished is run again: trials depend on nothing but their task.
    """

    def __init__(
        self, factory: ExecutorFactory, spec: SceneSpec, settings: Settings, skip: Skip = nothing_is_skipped
    ) -> None:
        self.spec = spec
        self.settings = settings
        self.skip = skip
        self._factory = factory
        self._executor = factory()
        self._scene = pickle.dumps((spec, settings))

    def __enter__(self) -> Trials:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def run(self, tasks: Sequence[Task]) -> Iterator[Outcome]:
        """The outcomes, in the order of the tasks.

        Raises:
            ImitateError: workers died again and again.
        """
        done, deaths = 0, 0
        while done < len(tasks):
            try:
                for outcome in self._executor.map(partial(_run_task, self._scene), tasks[done:]):
                    done += 1
                    yield outcome
            except BrokenExecutor as error:
                deaths += 1
                if deaths > _DEATHS_FORGIVEN:
                    raise ImitateError(
                        f"the processes that run trials died {deaths} times ({error}); out of memory, or "
                        "killed? Try again with --workers 1."
                    ) from error
                self._executor.shutdown(wait=False, cancel_futures=True)
                self._executor = self._factory()


def executors(workers: int, cluster_address: str = "") -> ExecutorFactory:
    """Local processes, or the workers of a cluster where there is an address of one.

    Args:
        workers: how many local processes; 0 runs the trials in this one.
        cluster_address: tcp://host:port of a scheduler; empty for none.

    Raises:
        ImitateError: the cluster cannot be used.
    """
    if not cluster_address:
        return process_pool(workers) if workers else _Here
    from imitate.learning.cluster import cluster

    return cluster(cluster_address)


def _run_task(scene: bytes, task: Task) -> Outcome:
    with _ONE_AT_A_TIME:
        simulator, watcher = _simulator(scene)
        if watcher is None:
            return simulator.run(task.start, task.policies)
        watcher.begin(task.expected, task.seed)
        return replace(simulator.run(task.start, task.policies, watcher), seen=watcher.sightings)


def _watcher(spec: SceneSpec, settings: Settings) -> Watcher | None:
    if not settings.learning.observe_trials:
        return None
    from imitate.learning.watching import Watcher  # 0.1 s that most trials have no use for

    return Watcher(spec, settings)


_kept: dict[bytes, tuple[Simulator, Watcher | None]] = {}


def _simulator(scene: bytes) -> tuple[Simulator, Watcher | None]:
    # Those of the latest scene are kept.
    if scene not in _kept:
        while _kept:
            simulator, watcher = _kept.popitem()[1]
            simulator.close()
            if watcher:
                watcher.close()
        spec, settings = pickle.loads(scene)
        _kept[scene] = Simulator(World(spec, settings.world), settings), _watcher(spec, settings)
    return _kept[scene]
