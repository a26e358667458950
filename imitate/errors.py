"""Errors that are written for the person: what was wrong, where, what was expected, what to do next."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any


class ImitateError(Exception):
    """Bad input. The views print its message alone; ``exit_code`` is the process's exit code."""

    exit_code = 1

    def __reduce__(self) -> tuple[Any, ...]:
        # Pickling calls the class with its message, and not every kind is made from one.
        return _remade, (type(self), self.args)


class FileError(ImitateError):
    """A file that cannot be read or written.

    Args:
        path: the file.
        problem: what is wrong with it, as a clause ("has no array 'hand'").
        remedy: what would work, as a sentence.
    """

    def __init__(self, path: Path | str, problem: str, remedy: str = "") -> None:
        super().__init__(f"{path}: {problem}." + (f" {remedy}" if remedy else ""))


class DemonstrationError(ImitateError):
    """A demonstration that cannot be: message names the field, what was got and what is expected."""


class SceneError(ImitateError):
    """A scene that cannot be built or a pose that the arm cannot reach."""


class UsageError(ImitateError):
    """A wrong word on the command line or in the settings."""

    exit_code = 2


class OutputError(ImitateError):
    """Stdout does not take what is written to it; its cause says why."""


class UnknownNameError(UsageError):
    """A name that is not among the valid ones; lists them and the nearest."""

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        choices = sorted(valid)
        near = get_close_matches(name, choices, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        super().__init__(f"unknown {kind} {name!r}.{hint} Valid: {', '.join(choices)}.")


def in_words(error: BaseException) -> str:
    """Any error for the person. What the machine refuses is named as that, and is no fault of imitate."""
    from concurrent.futures import BrokenExecutor  # it imports logging, which --help has no use for

    if isinstance(error, ImitateError):
        return str(error)
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    if isinstance(error, BrokenExecutor):
        return (
            f"a process that ran trials died ({error}). Was it killed, or is the memory full? Try again with "
            "--workers 1."
        )
    if isinstance(error, MemoryError):
        return f"the memory is full ({what}). Close other programs, or try with --workers 1."
    if isinstance(error, OSError):
        why = error.strerror or what
        return f"{error.filename}: {why}." if error.filename else f"the system refuses to go on: {why}."
    return f"unexpected {what}. This is a fault of imitate."


def _remade(kind: type[ImitateError], args: tuple[Any, ...]) -> ImitateError:
    return kind.__new__(kind, *args)
