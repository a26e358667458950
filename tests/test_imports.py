"""The core runs without the views: what it imports, seen in a fresh process."""

import subprocess
import sys
from pathlib import Path

PROBE = """
import importlib, pathlib, sys
import imitate
root = pathlib.Path(imitate.__file__).parent
files = [file.relative_to(root.parent).with_suffix("") for file in root.rglob("*.py")]
core = [file.parts for file in files if file.parts[1] not in ("cli", "tui", "session", "experiments")]
assert len(core) > 20, core
for parts in core:
    importlib.import_module(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
print(*sorted({"textual", "rich", "rerun", "typer", "open3d", "pandas", "matplotlib"} & set(sys.modules)))
"""


def test_the_core_imports_no_view_and_nothing_slow():
    done = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []


def test_trajectories_need_no_open3d():
    probe = """
import sys
sys.modules["open3d"] = None
from imitate import cli
cli.main(["segment", sys.argv[1], "--json"])
"""
    human_stack = Path(__file__).parents[1] / "fixtures" / "human_stack.npz"
    command = [sys.executable, "-c", probe, str(human_stack)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith('{"mode": "robust"')
