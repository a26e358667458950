"""A mapping given with a file holds for that file, and for no other that is opened later."""

from pathlib import Path

import numpy as np

from imitate.formats.mapping import Mapping
from imitate.tui.engine import with_mapping

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"


def test_only_the_file_that_was_given_is_mapped(tmp_path, human_stack):
    mine = tmp_path / "mine.npz"
    d = human_stack
    np.savez(mine, clock=d.t, ee=d.hand, a=d.objects[:, 0], b=d.objects[:, 1])
    said = {
        "time": "clock",
        "hand": {"pose": "ee"},
        "objects": {
            "cube": {"pose": "a", "size": [0.04] * 3},
            "base": {"pose": "b", "size": [0.05] * 3},
        },
    }
    engine = with_mapping(mine, Mapping.model_validate(said))
    assert engine.kind_of(mine) == engine.look(mine).kind == "demonstration"
    assert engine.read(mine, []).object_names == ("cube", "base")
    assert engine.look(FIXTURE).kind == "demonstration"
    assert engine.read(FIXTURE, []).object_names == ("cubeA", "cubeB")
