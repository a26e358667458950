"""Changes made by hand to a copy of the package: the ordinary tests of the changed file's room see each."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COPIED = ("imitate", "tests", "fixtures", "sessions", "pyproject.toml")
LEFT_OUT = shutil.ignore_patterns("__pycache__", "tui", ".*")
TESTS_FAILED = 1
"""pytest's exit code; others say that it could not run them."""

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Change:
    """A piece of a file's text and what it becomes."""

    what: str
    file: str
    before: str
    after: str

    @property
    def tests(self) -> list[str]:
        """Its room's; the file's own first, which mostly see it and take less time."""
        room, name = Path(self.file).parts
        own = f"tests/{room}/test_{name}"
        return [*([own] if (ROOT / own).exists() else []), f"tests/{room}"]


CHANGES = [
    Change(**change)
    for change in tomllib.loads(Path(__file__).with_name("hand_made.toml").read_text())["change"]
]


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All that the tests need, without the application's."""
    folder = tmp_path_factory.mktemp("copy")
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=LEFT_OUT)
        else:
            shutil.copy(ROOT / name, folder)
    return folder


def python(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs in a folder, whose package comes before the one that is installed."""
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False, timeout=1800
    )


def test_the_copy_is_what_is_run_and_passes_as_it_is(copy: Path) -> None:
    found = python(copy, "-c", "import imitate; print(imitate.__file__)").stdout
    assert Path(found.strip()).is_relative_to(copy)
    done = python(copy, "-m", "pytest", "-x", "tests/policy", "tests/world/test_golden.py")
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: f"{change.file}: {change.what}")
def test_the_ordinary_tests_of_its_room_fail(copy: Path, change: Change) -> None:
    path = copy / "imitate" / change.file
    text = path.read_text()
    assert text.count(change.before) == 1, f"{change.file} has changed: mend hand_made.toml"
    path.write_text(text.replace(change.before, change.after))
    try:
        runs = (python(copy, "-m", "pytest", "-x", tests) for tests in change.tests)
        done = next((run for run in runs if run.returncode), None)
    finally:
        path.write_text(text)
    assert done, f"{change.what}: no test saw it"
    assert done.returncode == TESTS_FAILED, done.stdout[-2000:]
