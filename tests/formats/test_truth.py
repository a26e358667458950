"""The right segmentation from a file, and what is said when it is none."""

import json

import pytest

from imitate.errors import FileError
from imitate.formats.truth import read_truth
from imitate.skill import Abstraction, Segment

REACH = {"start": 0, "end": 2.5, "relevant": ["hand"], "reference": "blue"}
CARRY = {"start": 2.5, "end": 4, "relevant": ["hand", "blue"], "reference": "table", "alternatives": []}


def test_segments_are_read_and_the_rest_passed_over(tmp_path):
    (tmp_path / "truth.json").write_text(json.dumps({"mode": "robust", "segments": [REACH, CARRY]}))
    assert read_truth(tmp_path / "truth.json", ("blue",)) == (
        Segment(0, 2.5, Abstraction(("hand",), "blue")),
        Segment(2.5, 4, Abstraction(("hand", "blue"), "table")),
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", "Input should be an object"),
        ('{"segments": []}', "segments: Tuple should have at least 1 item"),
        (json.dumps({"segments": [{"start": 0}]}), "segments.0.end: Field required"),
        (
            json.dumps({"segments": [REACH | {"end": 0}]}),
            "segments.0: ends at 0 s, not after its start",
        ),
        (
            json.dumps({"segments": [CARRY, REACH]}),
            "segments.1: starts at 0 s, before the one",
        ),
        (
            json.dumps({"segments": [REACH | {"reference": "red"}]}),
            "names 'red', which the demon",
        ),
        ('{"segments": [{"start": NaN}]}', "segments.0.start"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, content, message):
    (tmp_path / "truth.json").write_text(content)
    with pytest.raises(FileError) as caught:
        read_truth(tmp_path / "truth.json", ("blue",))
    assert message in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileError, match="no such file with the truth"):
        read_truth(tmp_path / "none.json", ())
