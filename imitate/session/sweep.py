"""Many sessions, each in one process from start to end; any `concurrent.futures.Executor` runs them."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context, parent_process
from multiprocessing.synchronize import Event as Flag

from imitate.errors import ImitateError
from imitate.formats.output import refuse_existing
from imitate.learning.trials import ExecutorFactory
from imitate.session.progress import Progress
from imitate.session.session import Request, run

_DEATHS_FORGIVEN = 3


@dataclass(frozen=True)
class Swept:
    """What came of one session.

    Attributes:
        request: what was asked for.
        progress: everything that its events said, without the steps.
        error: why it failed, for the person; empty where it ran to its end.
        wall_s: s that it took.
    """

    request: Request
    progress: Progress
    error: str
    wall_s: float

    @property
    def reproduced(self) -> bool:
        """Whether the task was reproduced in the end."""
        return bool(self.progress.finished and self.progress.finished.reproduced)


def sweep(
    requests: Sequence[Request],
    factory: ExecutorFactory,
    finished: Callable[[Swept], None] = lambda _: None,
) -> tuple[Swept, ...]:
    """Runs a session for each request; what came of each, in the order of the requests.

    A session that fails is an entry that says why; one whose worker died is run again. Each writes the files
    that it writes when run alone. Relative paths are looked up where the executor's workers run.

    Args:
        requests: their ``workers`` is 0 where sessions are to run their trials themselves.
        factory: of the executor; `session_pool`, or `learning.cluster.cluster` where the workers share a
            file system with this process.
        finished: hears of each session as it ends.

    Raises:
        FileError: a file to be written exists already, before anything is run.
    """
    for request in requests:
        for path in filter(None, (request.log, request.rrd)):
            refuse_existing(path, request.force)
    done: dict[int, Swept] = {}
    deaths = 0
    while len(done) < len(requests):
        try:
            _run_rest(requests, done, factory(), finished)
        except BrokenExecutor as error:
            deaths += 1
            if deaths > _DEATHS_FORGIVEN:
                raise ImitateError(
                    f"the processes that run sessions died {deaths} times ({error}); out of memory, or "
                    f"killed? {len(done)} of {len(requests)} sessions ended before, and their files are "
                    "whole. Run the others again with fewer --workers."
                ) from error
    return tuple(done[k] for k in range(len(requests)))


def _run_rest(
    requests: Sequence[Request],
    done: dict[int, Swept],
    executor: Executor,
    finished: Callable[[Swept], None],
) -> None:
    # What stands under a name now is what a worker left that died: it may be overwritten.
    try:
        futures: dict[Future[Swept], int] = {
            executor.submit(_session, replace(request, force=True)): k
            for k, request in enumerate(requests)
            if k not in done
        }
        for future in as_completed(futures):
            k = futures[future]
            swept = future.result()
            done[k] = replace(swept, request=requests[k])
            finished(done[k])
    except BaseException:
        executor.shutdown(wait=True, cancel_futures=True)
        raise
    executor.shutdown(wait=True)


def session_pool(workers: int) -> ExecutorFactory:
    """A factory of local processes that run a session at a time each.

    Cancelling, the end of this process included, stops each session after its present trial: its files are
    whole then, and end where it stopped.
    """
    return partial(_SessionPool, workers)


class _SessionPool(ProcessPoolExecutor):
    """Processes whose sessions stop when the pool is cancelled."""

    def __init__(self, workers: int) -> None:
        spawn = get_context("spawn")
        self._cancelled = spawn.Event()
        super().__init__(workers, mp_context=spawn, initializer=_prepare, initargs=(self._cancelled,))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        if cancel_futures:
            self._cancelled.set()
        super().shutdown(wait=wait, cancel_futures=cancel_futures)


_running = threading.Lock()
_stops: list[Flag] = []


def _prepare(cancelled: Flag) -> None:
    # Ctrl-C is the parent's affair. A worker whose parent was killed ends its session well, and then itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stops.append(cancelled)
    parent = parent_process()

    def wait() -> None:
        if parent is not None:
            parent.join()
            cancelled.set()
            with _running:
                os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def _should_stop() -> bool:
    return any(flag.is_set() for flag in _stops)


def _session(request: Request) -> Swept:
    progress, error = Progress(), ""
    began = time.monotonic()
    with _running:
        try:
            if not _should_stop():
                for event in run(request, _should_stop):
                    progress.fold(event)
        except ImitateError as problem:
            error = str(problem)
        except Exception as fault:
            error = f"unexpected {type(fault).__name__}: {fault}. This is a fault of imitate."
    return Swept(request, progress, error, round(time.monotonic() - began, 3))
