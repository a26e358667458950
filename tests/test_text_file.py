"""Text as people's editors write it: with a byte-order mark or without, in UTF-8 or UTF-16."""

import codecs
import json

import pytest

from imitate.formats.csv_file import csv_table
from imitate.formats.decisions import read_decisions
from imitate.formats.mapping import read_mapping
from imitate.formats.truth import read_truth
from imitate.settings import load_settings
from imitate.skill import Decision
from imitate.text_file import read_text
from imitate.tui.keys import read_keys
from imitate.world.robot import description_of, load_robot

ENCODINGS = {
    "utf-8": ("utf-8", b""),
    "utf-8 with a mark": ("utf-8", codecs.BOM_UTF8),
    "utf-16": ("utf-16-le", codecs.BOM_UTF16_LE),
    "utf-16, big-endian": ("utf-16-be", codecs.BOM_UTF16_BE),
}


@pytest.fixture(params=list(ENCODINGS))
def written(request, tmp_path):
    """Writes a text in one of the encodings; gives the file."""
    encoding, mark = ENCODINGS[request.param]

    def write(name, text):
        (tmp_path / name).write_bytes(mark + text.encode(encoding))
        return tmp_path / name

    return write


def test_the_mark_is_no_text(written):
    assert read_text(written("a.txt", "⟨é⟩\n")) == "⟨é⟩\n"


def test_every_file_that_people_write_is_read(written):
    assert load_settings(written("settings.toml", "[learning]\nalpha = 0.7\n")).learning.alpha == 0.7
    assert read_mapping(written("mapping.toml", 'length_unit = "mm"\n')).length_unit == "mm"
    assert read_keys(written("keys.toml", '[learn]\nstop = "S"\n')) == {"learn.stop": "S"}
    assert load_robot(str(written("robot.toml", description_of("panda")))) == load_robot("panda")
    table = csv_table(written("a.csv", "t,hand_x\n0,1\n1,2\n"))
    assert list(table.widths) == ["t", "hand_x"]
    decisions = written("decisions.json", json.dumps([{"kind": "merge", "segment": 0}]))
    assert read_decisions(decisions) == (Decision("merge", 0),)
    segment = {"start": 0, "end": 1, "relevant": ["hand"], "reference": "é"}
    (truth,) = read_truth(written("truth.json", json.dumps({"segments": [segment]})), ("é",))
    assert truth.abstraction.reference == "é"
