"""Work in a child process: what it says, how it stops, how it fails."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

import pytest

from imitate.errors import ImitateError
from imitate.tui.child import Asked, in_child

Emit = Callable[[Any], None]
Stop = Callable[[], bool]


def count(job: int, emit: Emit, _should_stop: Stop) -> None:
    for number in range(job):
        emit(number)


def count_slowly(job: int, emit: Emit, should_stop: Stop) -> None:
    for number in range(job):
        emit(number)
        time.sleep(0.02)
        if should_stop():
            return


def chatter(_job: None, emit: Emit, _should_stop: Stop) -> None:
    os.write(1, b"a C library's banner")
    os.write(2, b"a C library's warning")
    emit("said")


def refuse(_job: None, _emit: Emit, _should_stop: Stop) -> None:
    raise ImitateError("stack.npz: has no array 'hand'. Name it so.")


def break_down(_job: None, _emit: Emit, _should_stop: Stop) -> None:
    raise ZeroDivisionError("division by zero")


def die(_job: None, emit: Emit, _should_stop: Stop) -> None:
    emit("alive")
    os._exit(9)


def until_skipped(_job: None, emit: Emit, asked: Asked) -> None:
    emit("learning")
    while not asked.skips(1, 2):
        time.sleep(0.01)
    emit(asked.skips(1, 3))


def never() -> bool:
    return False


def test_everything_said_arrives_in_order() -> None:
    assert list(in_child(count, 500, never)) == list(range(500))


def test_it_stops_when_asked_to_and_says_what_it_did_until_then() -> None:
    heard: list[int] = []
    for number in in_child(count_slowly, 10_000, lambda: len(heard) > 2, patience=0.01):
        heard.append(number)
    assert heard == list(range(len(heard)))
    assert 3 <= len(heard) < 500


def test_what_c_code_prints_stays_off_the_screen(capfd: pytest.CaptureFixture[str]) -> None:
    assert list(in_child(chatter, None, never)) == ["said"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("work", "message"),
    [
        (refuse, r"stack\.npz: has no array 'hand'\. Name it so\."),
        (break_down, "unexpected ZeroDivisionError: division by zero"),
        (die, r"ended by itself \(exit code 9\).*--workers 1"),
    ],
)
def test_what_goes_wrong_is_an_error_in_words(work: Any, message: str) -> None:
    with pytest.raises(ImitateError, match=message):
        list(in_child(work, None, never))


def test_a_listener_that_goes_away_ends_the_child() -> None:
    story = in_child(count_slowly, 10_000, never)
    assert next(story) == 0
    started = time.monotonic()
    story.close()  # type: ignore[attr-defined]  # joins the child
    assert time.monotonic() - started < 5


def test_it_hears_which_formulation_is_given_up() -> None:
    heard: list[Any] = []
    story = in_child(until_skipped, None, never, to_skip=lambda: (1, 2) if heard else None, patience=0.01)
    for said in story:
        heard.append(said)
    assert heard == ["learning", False]
