"""What `imitate learn` says of a session on its way, for a person."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scripted

from imitate import cli, events
from imitate.cli import console
from imitate.session import session as module
from imitate.session.source import Source
from imitate.skill import InitiationSet

DEMONSTRATION = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"
TRIED = InitiationSet(
    ("hand", "blue"),
    "green",
    np.ones((4, 2, 7)),
    np.array([1.0, 1, 1, 0]),
    np.array([0.9, 0.8, 0.2, 0.6]),
    np.ones((2, 7)),
    np.eye(12),
    1.5,
    1.0,
    0.5,
)


@pytest.fixture
def narrated(capsys, tmp_path, monkeypatch):
    """What is on stderr when a session goes as this story."""
    monkeypatch.chdir(tmp_path)

    def run(story):
        monkeypatch.setattr(module, "run", lambda *_, **__: iter(story))
        with pytest.raises(SystemExit):
            cli.main(["learn", str(DEMONSTRATION), "--no-rrd"])
        return capsys.readouterr().err.splitlines()

    return run


def test_an_option_is_told_with_its_initiation_set_and_ends_that_miss_it(narrated):
    story = [
        replace(event, initiation=TRIED, ends=20, ends_inside=19 if event.segment == 1 else 20)
        if isinstance(event, events.OptionLearned)
        else event
        for event in scripted.session()
    ]
    said = narrated(story)
    assert "skill 2: learned" in said
    assert "skill 2: initiation set: precision 2/3, recall 2/3 (4 trials, 1 failed)" in said
    assert "skill 2: 1 of 20 ends of skill 1 lie outside its initiation set" in said
    assert not any(line.startswith("skill 3: 0 of") for line in said)


@pytest.mark.parametrize(("left_out", "code"), [(0.5, 3), (0.05, 0)])
def test_what_a_recording_lost_is_told_and_counts(capsys, tmp_path, monkeypatch, left_out, code):
    monkeypatch.chdir(tmp_path)

    def run(*_, heard, **__):
        heard(Source("film", "", scripted.demonstration(), notes=("half is gone",), left_out=left_out))
        return iter(scripted.session())

    monkeypatch.setattr(module, "run", run)
    with pytest.raises(SystemExit) as end:
        cli.main(["learn", str(DEMONSTRATION), "--no-rrd"])
    assert capsys.readouterr().err.splitlines()[0] == f"{DEMONSTRATION}: half is gone"
    assert end.value.code == code


def test_a_session_of_before_there_were_initiation_sets_is_told_without(narrated):
    said = narrated(scripted.session())
    assert "skill 1: learned" in said
    assert not any("initiation" in line for line in said)


def test_long_lines_are_wrapped_at_words_on_a_terminal_alone(capsys, monkeypatch):
    words = (
        "skill 2: cubeA did not follow the hand (0 of 20 starts, 0.00–0.16; cubeA was never grasped): more"
    )
    monkeypatch.setenv("COLUMNS", "80")
    console.narrate(words, wrapped=True)
    assert capsys.readouterr().err == words + "\n"
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    console.narrate(words, wrapped=True)
    lines = capsys.readouterr().err.splitlines()
    assert [len(line) <= 80 for line in lines] == [True, True]
    assert lines[1].startswith("    ")
    assert " ".join(line.strip() for line in lines) == words
