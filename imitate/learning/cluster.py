"""Trials on a cluster: an executor on a running scheduler of dask.distributed (`imitate[cluster]`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor
from functools import partial
from importlib.metadata import version
from typing import Any

from imitate.errors import ImitateError

_PATIENCE = 10.0
"""s to wait for the scheduler."""
_MATTERS = ("imitate", "pybullet", "numpy")
"""packages whose versions must be the same everywhere, or trials could differ from those run here."""


def cluster(address: str) -> Callable[[], Executor]:
    """A factory of executors that run on the scheduler at ``address``, such as tcp://host:8786.

    A worker that dies costs a repeat: the scheduler gives what it had to another one.

    Raises:
        ImitateError: dask.distributed is not installed, nothing answers, or workers are missing or unlike
            this installation; raised at once, before anything is run.
    """
    _connect(address).close()
    return partial(_executor, address)


def _executor(address: str) -> Executor:
    from distributed import KilledWorker
    from distributed.cfexecutor import ClientExecutor

    class ClusterExecutor(ClientExecutor):
        """Ends its connection with itself, and says in the standard's words that workers died."""

        def map(self, fn: Any, *iterables: Any, **kwargs: Any) -> Iterator[Any]:
            try:
                yield from super().map(fn, *iterables, **kwargs)
            except KilledWorker as error:
                raise BrokenExecutor(str(error)) from error

        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            super().shutdown(wait=wait and not cancel_futures)
            self._client.close()

    # Not pure: equal calls are to be run again, as everywhere else.
    executor: Executor = ClusterExecutor(_connect(address), pure=False)
    return executor


def _connect(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        raise ImitateError(
            "--cluster needs dask.distributed, which is not installed: pip install distributed"
        ) from error
    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ImitateError(
            f"--cluster {address}: no scheduler answers there ({error or type(error).__name__}). Start "
            "one with `dask scheduler` and give its address, such as tcp://localhost:8786."
        ) from error
    try:
        _check_workers(client, address)
    except ImitateError:
        client.close()
        raise
    return client


def _check_workers(client: Any, address: str) -> None:
    found = client.run(_versions)
    if not found:
        raise ImitateError(
            f"--cluster {address}: the scheduler has no workers. Start some: "
            f"dask worker {address} --nthreads 1"
        )
    here = _versions()
    for worker, there in found.items():
        if there != here:
            raise ImitateError(
                f"--cluster {address}: the worker {worker} has {_listed(there)}, and here it is "
                f"{_listed(here)}; their trials could differ. Install the same versions on both."
            )


def _versions() -> dict[str, str]:
    return {name: version(name) for name in _MATTERS}


def _listed(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in versions.items())
