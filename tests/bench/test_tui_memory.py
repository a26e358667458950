"""The guided session's memory, and its child's, over a session of 500 trials: it does not grow with them.

Run: pytest -m bench -s tests/bench/test_tui_memory.py
"""

import shutil
import time
from pathlib import Path

import pytest
from terminal import Terminal

from imitate.formats.session_log import summarise

pytestmark = [
    pytest.mark.bench,
    pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed"),
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc"),
]
SOURCE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"
SETTINGS = "[learning]\nevaluation_starts = 150\n"
EARLY = 100
"""trials after which everything that is loaded once is loaded."""
MOST = 40.0
"""MiB that 400 trials may add: a screen's worth of text; one trial's steps alone are 3 MiB in memory."""


def children(process):
    tasks = Path(f"/proc/{process}/task").glob("*/children")
    return [int(child) for task in tasks for child in task.read_text().split()]


def resident(process):
    """MiB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS")), 0.0)


def test_memory_over_five_hundred_trials(tmp_path, capsys):
    shutil.copy(SOURCE, tmp_path)
    (tmp_path / "long.toml").write_text(SETTINGS)
    terminal = Terminal(tmp_path, SOURCE.name, "--workers", "2", "--settings", "long.toml")
    log = tmp_path / "sessions" / "human_stack-0.mcap"
    seen = []
    try:
        terminal.wait("skill 1 may be")
        terminal.keys("s")
        terminal.wait("learning")
        program = terminal.process
        while learning := [child for child in children(program) if children(child)]:
            seen.append((log.stat().st_size if log.exists() else 0, resident(program), resident(learning[0])))
            time.sleep(1)
    finally:
        terminal.kill()
    trials, size = summarise(log).trials, log.stat().st_size
    _, early, early_child = next(row for row in seen if row[0] >= size * EARLY / trials)
    _, late, late_child = seen[-2]
    with capsys.disabled():
        print(
            f"\n{trials} trials, {size / 1e6:.0f} MB of log; from trial {EARLY} to the last: the program "
            f"from {early:.0f} to {late:.0f} MiB, its child from {early_child:.0f} to {late_child:.0f} MiB"
        )
    assert trials >= 500
    assert late - early < MOST
    assert late_child - early_child < MOST
