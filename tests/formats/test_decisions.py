"""Decisions from a file, and what is said when it holds something else."""

import pytest

from imitate.errors import FileError
from imitate.formats.decisions import read_decisions
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
        ('[{"kind": "push"}]', "0.kind: Input should be 'move', 'relabel', 'split', 'merge' or 'undo'"),
        ('[{"kind": "undo"}, {"kind": "move", "at": 3}]', "1.at: Unexpected keyword argument"),
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
