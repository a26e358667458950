"""New files: never over an existing one unasked, and never half written under the final name."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from imitate.errors import FileError


@contextmanager
def new_file(path: Path, force: bool = False) -> Iterator[Path]:
    """A temporary name in the same folder, renamed to ``path`` when the block ends well.

    Raises:
        FileError: ``path`` exists and ``force`` is not given, or its folder cannot be written.
    """
    path = Path(path)
    refuse_existing(path, force)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        refuse_existing(path, force)
        temporary.replace(path)
    except OSError as error:
        raise FileError(
            path, f"cannot be written ({error.strerror or error})", "Choose another place."
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def refuse_existing(path: Path, force: bool = False) -> None:
    """Raises FileError when something is at ``path`` already, unless ``force``."""
    if path.is_dir():
        raise FileError(path, "is a folder", "Give the name of a file.")
    if path.exists() and not force:
        raise FileError(path, "exists already", "Choose another name, or overwrite it with --force.")


def require_mcap(path: Path) -> None:
    """Raises FileError when a recording or a session would not be called .mcap."""
    if path.suffix != ".mcap":
        raise FileError(path, f"cannot be written: unknown suffix {path.suffix!r}", "Use .mcap.")


def free_name(folder: Path, stem: str, suffix: str) -> Path:
    """The first of stem, stem-2, stem-3 … in ``folder`` that does not exist yet."""
    names = (f"{stem}{'' if n == 1 else f'-{n}'}{suffix}" for n in count(1))
    return next(path for name in names if not (path := folder / name).exists())
