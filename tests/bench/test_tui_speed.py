"""The guided session: its first paint, and how long a key press takes while two workers learn.

Run: pytest -m bench -s tests/bench/test_tui_speed.py
"""

import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from terminal import Terminal

pytestmark = [
    pytest.mark.bench,
    pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed"),
]
SOURCE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"
PRESSES = 60


def test_keys_while_learning(tmp_path, capsys):
    shutil.copy(SOURCE, tmp_path)
    began = time.monotonic()
    terminal = Terminal(tmp_path, SOURCE.name, "--workers", "2")
    waits = []
    try:
        terminal.wait("imitate", every=0.01)
        painted = time.monotonic() - began
        terminal.wait("skill 1 may be")
        terminal.keys("s")
        terminal.wait("learning")
        time.sleep(5)  # the workers have begun
        for k in range(PRESSES):
            # the legend below the curve says what is drawn: 2 adds and takes away the cost's end
            shown, hidden = ("e end", "") if k % 2 == 0 else ("", "e end")
            pressed = time.monotonic()
            terminal.keys("2")
            terminal.wait(shown, without=hidden, every=0.01)
            waits.append(time.monotonic() - pressed)
            time.sleep(0.1)
    finally:
        terminal.kill()
    half, most = np.percentile(waits, [50, 95]) * 1e3
    with capsys.disabled():
        print(f"\nfirst paint {painted:.2f} s; a key while two workers learn, with what asking tmux takes:")
        print(f"median {half:.0f} ms, 95 % {most:.0f} ms of {PRESSES}")


def test_keys_while_looking_through_a_demonstration(tmp_path, capsys):
    shutil.copy(SOURCE, tmp_path)
    terminal = Terminal(tmp_path, SOURCE.name)
    waits = []
    try:
        screen = terminal.wait("skill 1 may be", "hand to cubeA", "90 %")
        for k in range(PRESSES):
            if k == PRESSES // 2:
                terminal.keys("v")  # the distances in the place of the scene
                screen = terminal.wait("cm from the hand to")
            (present,) = re.findall(r"\d+\.\d\d s  hand to", screen)
            pressed = time.monotonic()
            terminal.keys(",")
            screen = terminal.wait("s  hand to", without=present, every=0.01)
            waits.append(time.monotonic() - pressed)
            time.sleep(0.1)
    finally:
        terminal.kill()
    half, most = np.percentile(waits, [50, 95]) * 1e3
    with capsys.disabled():
        print("\na frame back in Review, with what asking tmux takes:")
        print(f"median {half:.0f} ms, 95 % {most:.0f} ms of {PRESSES}")
