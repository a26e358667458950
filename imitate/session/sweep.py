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
from typing import ParamSpec, TypeVar

from imitate.errors import ImitateError, in_words
from imitate.formats.output import refuse_existing
from imitate.learning.starting import starting
from imitate.learning.trials import ExecutorFactory
from imitate.session.progress import Progress
from imitate.session.session import Request, run
from imitate.session.source import Source
from imitate.session.spare import Cores, Sharing

_P = ParamSpec("_P")
_Result = TypeVar("_Result")
_DEATHS_FORGIVEN = 3
_WHAT = "the processes that run sessions"


@dataclass(frozen=True)
class Swept:
    """What came of one session.

    Attributes:
        request: what was asked for.
        progress: everything that its events said, without the steps.
        error: why it failed, for the person; empty where it ran to its end.
        wall_s: s that it took.
        source: what it was learned from; None where that was not read.
    """

    request: Request
    progress: Progress
    error: str
    wall_s: float
    source: Source | None = None

    @property
    def reproduced(self) -> bool:
        """Whether the task was reproduced in the end."""
        return bool(self.progress.finished and self.progress.finished.reproduced)


class Board:
    """Where each session of a sweep is, for whoever looks.

    Plain numbers in shared memory: nobody waits for anybody, whoever dies.
    """

    def __init__(self, sessions: int) -> None:
        self._numbers = get_context("spawn").RawArray("i", 2 * sessions)

    def note(self, session: int, skill: int, trials: int) -> None:
        """Session number ``session`` of the sweep is at this skill, from 1, after so many trials."""
        self._numbers[2 * session : 2 * session + 2] = [skill, trials]

    def clear(self, session: int) -> None:
        """That session has ended."""
        self.note(session, 0, 0)

    def running(self) -> dict[int, tuple[int, int]]:
        """Session → (skill, trials) of those that have begun to learn and not ended."""
        pairs = zip(self._numbers[::2], self._numbers[1::2], strict=True)
        return {k: pair for k, pair in enumerate(pairs) if pair[0]}


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
            executor.submit(run_session, k, replace(request, force=True)): k
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


def session_pool(workers: int, board: Board | None = None) -> ExecutorFactory:
    """A factory of local processes that run a session at a time each, and note on ``board`` how far it is.

    A core that has no session left runs trials of those that still run.

    Cancelling, the end of this process included, stops each session after its present trial: its files are
    whole then, and end where it stopped.
    """
    return partial(_made, workers, board)


def _made(workers: int, board: Board | None) -> _SessionPool:
    with starting(_WHAT):
        return _SessionPool(workers, board)


class _SessionPool(ProcessPoolExecutor):
    """Processes whose sessions stop when the pool is cancelled."""

    def __init__(self, workers: int, board: Board | None) -> None:
        spawn = get_context("spawn")
        self._cancelled = spawn.Event()
        self._cores = Cores(workers)
        given = self._cancelled, self._cores, board
        super().__init__(workers, mp_context=spawn, initializer=_prepare, initargs=given)

    def submit(self, fn: Callable[_P, _Result], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_Result]:
        self._cores.begin()
        with starting(_WHAT):
            return super().submit(partial(_counted, fn, *args, **kwargs))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        if cancel_futures:
            self._cancelled.set()
        super().shutdown(wait=wait, cancel_futures=cancel_futures)


_running = threading.Lock()
_stops: list[Flag] = []
_boards: list[Board] = []
_cores: list[Cores] = []


def _prepare(cancelled: Flag, cores: Cores, board: Board | None) -> None:
    # Ctrl-C is the parent's affair. A worker whose parent was killed ends its session well, and then itself.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stops.append(cancelled)
    _cores.append(cores)
    if board:
        _boards.append(board)
    parent = parent_process()

    def wait() -> None:
        if parent is not None:
            parent.join()
            cancelled.set()
            with _running:
                os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def _counted(fn: Callable[_P, _Result], *args: _P.args, **kwargs: _P.kwargs) -> _Result:
    try:
        return fn(*args, **kwargs)
    finally:
        for cores in _cores:
            cores.end()


def _should_stop() -> bool:
    return any(flag.is_set() for flag in _stops)


def _watching(_done: int, _of: int) -> None:
    if _should_stop():
        raise ImitateError("stopped before its first trial.")


def run_session(number: int, request: Request) -> Swept:
    """One session, in a process of `session_pool` or any other.

    Args:
        number: its place on the pool's board, if that has one.
        request: its ``workers`` is 0 where the session is to run its trials itself, and on what cores its
            pool can spare.
    """
    progress, error, sources = Progress(), "", list[Source]()
    alone = request.workers == 0 and not request.cluster
    trials = partial(Sharing, _cores[-1]) if alone and _cores else None
    began = time.monotonic()
    with _running:
        try:
            if not _should_stop():
                for event in run(request, _should_stop, _watching, factory=trials, heard=sources.append):
                    progress.fold(event)
                    _note(number, progress)
        except Exception as problem:
            error = in_words(problem)
        for board in _boards:
            board.clear(number)
    source = sources[0] if sources else None
    return Swept(request, progress, error, round(time.monotonic() - began, 3), source)


def _note(number: int, progress: Progress) -> None:
    for board in _boards:
        skill = progress.present.formulation.segment + 1 if progress.present else 0
        board.note(number, skill, progress.counts.total())
