"""Decisions from a file, and what is said when it holds something else."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from imitate.errors import FileError
from imitate.formats.decisions import read_decisions, write_decisions
from imitate.skill import Abstraction, Decision


def test_every_kind_is_read(tmp_path):
    file = tmp_path / "decisions.json"
    file.write_text(
        """[{"kind": "move", "segment": 0, "time": 8.3}, {"kind": "split", "segment": 1, "time": 9},
        {"kind": "merge", "segment": 1}, {"kind": "undo"},
        {"kind": "relabel", "segment": 1,
         "abstraction": {"relevant": ["hand", "blue"], "reference": "green"}}]"""
    )
    assert read_decisions(file) == (
        Decision("move", 0, 8.3),
        Decision("split", 1, 9.0),
        Decision("merge", 1),
        Decision("undo"),
        Decision("relabel", 1, abstraction=Abstraction(("hand", "blue"), "green")),
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind: move", "Invalid JSON"),
        ('{"kind": "move"}', "Input should be a valid array"),
        (
            '[{"kind": "push"}]',
            "0.kind: Input should be 'move', 'relabel', 'split',",
        ),
        ('[{"kind": "undo"}, {"kind": "move", "at": 3}]', "1.at: Unexpected keyword argument"),
        ('[{"kind": "undo"}, {"kind": "move", "segment": 0}]', "1.time: missing, and move needs it"),
        ('[{"kind": "merge"}]', "0.segment: missing, and merge needs it"),
        ('[{"kind": "relabel", "segment": 2}]', "0.abstraction: missing, and relabel needs it"),
        ('[{"kind": "split", "time": "late"}]', "0.time: Input should be a valid number"),
        (
            '[{"kind": "relabel", "abstraction": {"relevant": ["hand"]}}]',
            "0.abstraction.reference: Field required",
        ),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, message):
    file = tmp_path / "decisions.json"
    file.write_text(text)
    with pytest.raises(FileError, match="Expected a list such as") as caught:
        read_decisions(file)
    assert message in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileError, match="no such decisions file"):
        read_decisions(tmp_path / "none.json")


NAMES = st.text(min_size=1, max_size=6)
SEGMENTS, TIMES = st.integers(0, 9), st.floats(0, 1e4)
DECISIONS = st.lists(
    st.one_of(
        st.builds(Decision, st.sampled_from(["move", "split"]), SEGMENTS, TIMES),
        st.builds(Decision, st.just("merge"), SEGMENTS),
        st.builds(Decision, st.sampled_from(["reset", "undo", "redo"])),
        st.builds(
            lambda k, names, to: Decision("relabel", k, abstraction=Abstraction(("hand", *names), to)),
            SEGMENTS,
            st.lists(NAMES, max_size=3),
            NAMES,
        ),
    ),
    max_size=5,
).map(tuple)


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(DECISIONS)
def test_what_is_written_is_read(tmp_path, decisions):
    write_decisions(tmp_path / "decisions.json", decisions, force=True)
    assert read_decisions(tmp_path / "decisions.json") == decisions


def test_what_is_written_is_for_people_too(tmp_path):
    file = tmp_path / "decisions.json"
    write_decisions(file, [Decision("merge", 1), Decision("undo")])
    assert file.read_text() == '[{"kind": "merge", "segment": 1},\n {"kind": "undo"}]\n'
    assert json.loads(file.read_text())
    with pytest.raises(FileError, match=r"decisions.json: exists already"):
        write_decisions(file, [])
