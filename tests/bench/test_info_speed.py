"""imitate info of a session of 1 GB: from its summary, in less than a second and 200 MiB.

Run: pytest -m bench -s tests/bench/test_info_speed.py
"""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import recorded
import scripted

from imitate.events import SessionFinished
from imitate.formats.session_writer import SessionWriter

pytestmark = pytest.mark.bench
SIZE = 1_000_000_000
# In a small process of its own: a child counts the memory of the one that it was forked from as its own.
MEASURED = """
import json, resource, subprocess, sys, time
began = time.monotonic()
subprocess.run(sys.argv[1:], check=True, capture_output=True)
wall, used = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024]))
"""


def test_info_of_a_large_session(tmp_path, capsys):
    path = tmp_path / "large.mcap"
    told = list(scripted.session())
    trial = next(event for event in told if type(event).__name__ == "TrialFinished")
    record = recorded.record(20_000)
    count = 0
    with SessionWriter(path) as log:
        for event in told[:3]:
            log.write(event)
        while path.stat().st_size < SIZE:  # another start, so that no two trials share their steps
            start = replace(record.start, force=float(count))
            log.write(replace(trial, trial=count, record=replace(record, start=start)))
            count += 1
        log.write(next(event for event in told if isinstance(event, SessionFinished)))
    program = str(Path(sys.executable).with_name("imitate"))
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, program, "info", str(path)],
        check=True,
        capture_output=True,
        text=True,
    )
    wall, processor, mebibytes = json.loads(done.stdout)
    with capsys.disabled():
        print(
            f"\ninfo of {path.stat().st_size / 1e9:.2f} GB, {count} trials: {wall:.2f} s by the clock, "
            f"{processor:.2f} s of the processor, {mebibytes:.0f} MiB"
        )
    assert mebibytes < 200
