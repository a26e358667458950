"""The real program in a real terminal: tmux types the keys and says what the screen shows."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

PROGRAM = [sys.executable, "-c", "from imitate.cli import main; main()"]


class Terminal:
    """A terminal of 80 × 24 with the program in it, in a folder of its own."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self._server = f"imitate-{folder.name}-{time.monotonic_ns()}"
        size = ["-x", "80", "-y", "24", "-c", str(folder)]
        self._tmux("-f", "/dev/null", "new-session", "-d", *size, *PROGRAM, "tui", *arguments)

    def _tmux(self, *arguments: str, check: bool = True) -> str:
        command = ["tmux", "-L", self._server, *arguments]
        return subprocess.run(command, check=check, capture_output=True, text=True).stdout

    @property
    def screen(self) -> str:
        """What is on the screen; empty once the program has ended."""
        return self._tmux("capture-pane", "-p", check=False)

    @property
    def process(self) -> int:
        """The program's process."""
        return int(self._tmux("display-message", "-p", "#{pane_pid}"))

    def keys(self, *names: str) -> None:
        """Press keys, by tmux's names."""
        self._tmux("send-keys", *names)

    def wait(self, *texts: str, without: str = "", seconds: float = 60, every: float = 0.2) -> str:
        """The screen, once all of these are on it, and ``without`` is not; looked at ``every`` so many s."""
        ends = time.monotonic() + seconds
        while True:
            screen = self.screen
            if all(text in screen for text in texts) and not (without and without in screen):
                return screen
            assert time.monotonic() < ends, f"{texts} did not come in {seconds} s:\n{screen}"
            time.sleep(every)

    def wait_end(self, seconds: float = 60) -> None:
        """Until the program has ended, and its terminal with it."""
        ends = time.monotonic() + seconds
        while self.screen:
            assert time.monotonic() < ends, f"it did not end in {seconds} s:\n{self.screen}"
            time.sleep(0.2)

    def kill(self) -> None:
        """Close the terminal over the program's head."""
        self._tmux("kill-server", check=False)
