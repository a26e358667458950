"""Errors go from process to process with their messages; one that could not would break a pool of workers."""

import pickle

import pytest

from imitate.errors import DemonstrationError, FileError, ImitateError, UnknownNameError, UsageError


@pytest.mark.parametrize(
    "error",
    [
        ImitateError("no hand"),
        FileError("a.npz", "has no array 'hand'", "Record it again."),
        DemonstrationError("t: empty"),
        UnknownNameError("task", "stak", ("stack", "push")),
    ],
)
def test_survives_pickling(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert again.exit_code == error.exit_code


def test_a_wrong_word_is_wrong_usage():
    with pytest.raises(
        UsageError, match=r"unknown task 'stak'\. Did you mean 'stack'\? Valid: push, stack\."
    ):
        raise UnknownNameError("task", "stak", ("stack", "push"))
