"""A sweep of twenty short sessions with one worker and with two, in one run: how much sooner two are done.

Run on an otherwise idle machine: pytest -m bench -s tests/bench/test_workers.py
"""

import os
import resource
import time

import pytest

from imitate.formats.demonstrations import write_demonstration
from imitate.session.session import Request
from imitate.session.sweep import session_pool, sweep
from imitate.settings import parse_settings

pytestmark = pytest.mark.bench
SESSIONS = 20
RATIO = 1.8
SHORT = parse_settings(
    {
        "learning": {
            "evaluation_starts": 2,
            "reproduction_starts": 2,
            "candidate_starts": 1,
            "first_rollouts": 2,
            "updates": 1,
        }
    }
)


def measured(source, folder, workers):
    """Seconds by the clock, and of processor in the workers, of the whole sweep; and the logs' bytes."""
    folder.mkdir()
    asked = [Request(source, SHORT, seed, 0, log=folder / f"{seed}.mcap") for seed in range(SESSIONS)]
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    results = sweep(asked, session_pool(workers))
    clock, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    assert not any(swept.error for swept in results)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return clock, processor, [request.log.read_bytes() for request in asked]


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core has nothing to share out")
def test_two_workers_are_nearly_twice_one(short_demonstration, tmp_path, capsys):
    source = tmp_path / "carry.npz"
    write_demonstration(short_demonstration, source)
    load = os.getloadavg()[0]
    one, processor_one, logs_one = measured(source, tmp_path / "one", 1)
    two, processor_two, logs_two = measured(source, tmp_path / "two", 2)
    with capsys.disabled():
        print(
            f"\n{SESSIONS} sessions, {os.cpu_count()} cores, load {load:.1f} before and "
            f"{os.getloadavg()[0]:.1f} after"
            f"\none worker   {one:6.1f} s, {processor_one:6.1f} s of processor"
            f"\ntwo workers  {two:6.1f} s, {processor_two:6.1f} s of processor"
            f"\nratio        {one / two:6.2f}  (at least {RATIO})"
        )
    assert logs_one == logs_two
    assert one / two >= RATIO
