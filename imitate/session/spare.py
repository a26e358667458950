"""Cores that a sweep has no more sessions for: trials of the sessions that are left run there."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import suppress
from functools import partial
from multiprocessing import get_context
from typing import Any

from imitate.errors import ImitateError
from imitate.learning.trials import process_pool


class Cores:
    """How many cores a pool has, and who uses them; its processes share the numbers.

    Args:
        count: of the pool; each session uses one of its own.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._numbers = get_context("spawn").Array("i", 2)  # sessions not ended; cores lent to them

    def begin(self) -> None:
        """One more session is to be run."""
        with self._numbers:
            self._numbers[0] += 1

    def end(self) -> None:
        """One has ended."""
        with self._numbers:
            self._numbers[0] -= 1

    def borrow(self, has: int) -> bool:
        """Takes one more core for a session that has borrowed so many; whether there was one for it.

        What is spare is shared out evenly.
        """
        with self._numbers:
            sessions, lent = int(self._numbers[0]), int(self._numbers[1])
            spare = self._count - sessions
            granted = lent < spare and has * sessions < spare
            self._numbers[1] += granted
        return granted

    def give_back(self, count: int) -> None:
        """So many borrowed cores are free again."""
        with self._numbers:
            self._numbers[1] -= count


class Sharing(Executor):
    """This process, and a process on each core that it can borrow meanwhile.

    Outcomes come in the order of their tasks. This process takes the first that is left, and each helper
    the last.
    """

    def __init__(self, cores: Cores) -> None:
        self._cores = cores
        self._helpers: list[Executor] = []
        self._ready: list[Executor] = []
        self._batch = _Batch(print, [])
        self._borrow()

    def map(self, fn: Callable[..., Any], *iterables: Iterable[Any], **_: Any) -> Iterator[Any]:
        """As the standard's; each task that runs here does so when its outcome is asked for.

        Raises:
            BrokenExecutor: a helper died.
        """
        batch = self._batch = _Batch(fn, list(zip(*iterables, strict=True)))
        for helper in tuple(self._ready):
            batch.lend(helper)
        try:
            for k in range(batch.size):
                self._borrow()
                yield batch.outcome(k)
        finally:
            batch.end()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the helpers, and gives their cores back."""
        for helper in self._helpers:
            helper.shutdown(wait=wait, cancel_futures=cancel_futures)
        self._cores.give_back(len(self._helpers))
        self._helpers, self._ready = [], []

    def _borrow(self) -> None:
        while self._cores.borrow(len(self._helpers)):
            try:
                helper = process_pool(1)()
            except ImitateError:  # the system starts no more processes: this one goes on alone
                self._cores.give_back(1)
                return
            self._helpers.append(helper)
            # It takes a second to start: nothing waits for it until it answers.
            helper.submit(os.getpid).add_done_callback(partial(self._use, helper))

    def _use(self, helper: Executor, answer: Future[int]) -> None:
        if not answer.cancelled() and not answer.exception():
            self._ready.append(helper)
            self._batch.lend(helper)


class _Batch:
    # Tasks that are taken from both ends: by outcome() from the first on, by lend() from the last.

    def __init__(self, fn: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> None:
        self.size = len(tasks)
        self._fn = fn
        self._tasks = tasks
        self._left = deque(range(1, len(tasks)))  # the first is not worth sending
        self._lent: dict[int, Future[Any]] = {}
        self._taking = threading.Lock()

    def lend(self, helper: Executor) -> None:
        # The last that is left, and once it is done the next; a helper that died gets none.
        with suppress(BrokenExecutor):
            with self._taking:
                if not self._left:
                    return
                k = self._left[-1]
                future = self._lent[k] = helper.submit(self._fn, *self._tasks[k])
                self._left.pop()
            future.add_done_callback(partial(self._lend_again, helper))

    def _lend_again(self, helper: Executor, done: Future[Any]) -> None:
        if not done.cancelled() and not done.exception():
            self.lend(helper)

    def outcome(self, k: int) -> Any:
        with self._taking:
            here = k not in self._lent
            if here and k:
                self._left.popleft()
        return self._fn(*self._tasks[k]) if here else self._lent[k].result()

    def end(self) -> None:
        with self._taking:
            self._left.clear()
