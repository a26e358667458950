"""The sessions of a folder: which there are, how each ended, and which may go."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Literal

from imitate.errors import FileError
from imitate.events import SessionFinished, SessionStarted
from imitate.formats.growing import is_locked
from imitate.formats.kind import kind_of
from imitate.formats.session_log import SessionReader, summarise

Outcome = Literal["reproduced", "not reproduced", "stopped", "cut", "running"]


@dataclass(frozen=True)
class Entry:
    """One session.

    Attributes:
        path: its file.
        source: the demonstration's name; empty where the file was cut before it.
        seed: None likewise.
        outcome: cut: the file's end is missing; stopped: it is whole, and the session was ended early;
            running: it is being written.
        trials: how many finished.
        bytes: of the session and of what lies beside it for Rerun.
        changed: when it was written last.
    """

    path: Path
    source: str
    seed: int | None
    outcome: Outcome
    trials: int
    bytes: int
    changed: datetime

    @property
    def files(self) -> tuple[Path, ...]:
        """The session's and, where there is one, Rerun's beside it."""
        return _files(self.path)


def entries(folder: Path, looked: Callable[[int, int], None] = lambda *_: None) -> Iterator[Entry]:
    """The sessions in a folder, the latest first; files that are none are passed over.

    Args:
        folder: where to look; folders in it are not looked into.
        looked: hears of (files looked at, files in all).

    Raises:
        FileError: no such folder.
    """
    if not folder.is_dir():
        problem = "is a file" if folder.exists() else "no such folder"
        raise FileError(folder, problem, "Sessions are in sessions/ unless `learn -o` says otherwise.")
    files = sorted(folder.glob("*.mcap"), key=lambda p: (-p.stat().st_mtime, p.name))
    for number, path in enumerate(files, start=1):
        if (entry := _entry(path)) is not None:
            yield entry
        looked(number, len(files))


def chosen(
    among: Sequence[Entry], outcomes: Sequence[Outcome], older: float | None, now: datetime
) -> tuple[Entry, ...]:
    """Those that ended in one of these ways (in any, if none is named) and are older than so many days.

    One that is being written is never among them.
    """
    before = now if older is None else now - timedelta(days=older)
    ended = [e for e in among if e.outcome != "running" and e.changed <= before]
    return tuple(e for e in ended if not outcomes or e.outcome in outcomes)


def remove(entry: Entry) -> None:
    """Deletes a session and what lies beside it for Rerun.

    Raises:
        FileError: it cannot be deleted.
    """
    for path in entry.files:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise FileError(path, f"cannot be deleted ({error.strerror})") from error


def _files(path: Path) -> tuple[Path, ...]:
    beside = path.with_suffix(".rrd")
    return (path, beside) if beside.exists() else (path,)


def _entry(path: Path) -> Entry | None:
    try:
        if kind_of(path) != "session":
            return None
        summary = summarise(path)
        started, finished = _ends(path)
    except (FileError, OSError):  # the second where one may not read it, or it is gone by now
        return None
    outcome: Outcome = "running" if is_locked(path) else "cut" if summary.damage else "stopped"
    if finished and not summary.damage:
        outcome = "reproduced" if finished.reproduced else "not reproduced"
    return Entry(
        path=path,
        source=started.source if started else "",
        seed=started.seed if started else None,
        outcome=outcome,
        trials=summary.trials,
        bytes=sum(file.stat().st_size for file in _files(path)),
        changed=datetime.fromtimestamp(path.stat().st_mtime, UTC),
    )


def _ends(path: Path) -> tuple[SessionStarted | None, SessionFinished | None]:
    # Its first and its last event.
    found = list(SessionReader(path).events(only=(SessionStarted, SessionFinished)))
    started = [event for event in found if isinstance(event, SessionStarted)]
    finished = [event for event in found if isinstance(event, SessionFinished)]
    return next(iter(started), None), next(reversed(finished), None)
