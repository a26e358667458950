"""What a session starts from, and what is said of how it was read."""

import os
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from bags import bag

from imitate.demonstration import Demonstration
from imitate.perception import observe as watching
from imitate.rgbd import Intrinsics
from imitate.session.source import read_source
from imitate.settings import Settings

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"


def test_a_demonstration_says_how_its_times_were_read(tmp_path: Path, human_stack: Demonstration) -> None:
    with np.load(FIXTURE) as held:
        np.savez(tmp_path / "ms.npz", **{**held, "t": 1000 * (held["t"] + 1.7e9)})
    source = read_source(tmp_path / "ms.npz", Settings(), 0)
    assert source.notes == (
        "its times are milliseconds since 1970 and read as such; time_unit in a mapping says otherwise",
    )
    np.testing.assert_allclose(source.demonstration.t, human_stack.t - human_stack.t[0], atol=1e-3)
    assert not source.much_lost
    assert read_source(FIXTURE, Settings(), 0).notes == ()


@pytest.mark.parametrize(("gone", "much"), [((3, 9, 15, 21, 27, 33), True), ((20,), False)])
def test_a_recording_says_what_it_lost(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    human_stack: Demonstration,
    gone: tuple[int, ...],
    much: bool,
) -> None:
    camera = Intrinsics(64, 48, 60, 60, 31.5, 23.5)
    with bag(tmp_path / "film.mcap") as made:
        made.info("/c/camera_info", camera)
        for k in range(40):
            made.image("/c/depth", np.full((48, 64), 1000, np.uint16), "16UC1", 100 + k / 10)
            off = 30 if k in gone else 0
            made.image("/c/colour", np.full((48, 64, 3), 200, np.uint8), "rgb8", 100 + k / 10 - off)

    def observed(recording, *_):
        recording.survey()
        first = SimpleNamespace(doubts=("table: doubtful",))
        return SimpleNamespace(demonstration=human_stack, lost_frames={"cubeA": 3}, first=first)

    monkeypatch.setattr(watching, "observe", observed)
    source = read_source(tmp_path / "film.mcap", Settings(), 0)
    words = "pictures of /c/colour are left out" if much else "pictures of /c/colour is left out"
    assert source.notes[0].startswith(f"{len(gone)} of 40 {words}: stamped more than 1 s off")
    assert source.notes[-2] == "table: doubtful"
    assert source.notes[-1] == "cubeA: out of sight in 3 frames; missing there"
    assert source.left_out == pytest.approx(len(gone) / 40)
    assert source.much_lost == much


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a file's name has to be text")
def test_a_files_name_that_is_no_text_is_told_as_well_as_it_can_be(tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"caf\xe9.npz")
    shutil.copy(FIXTURE, path)
    assert read_source(path, Settings(), 0).name == "caf\ufffd.npz"
