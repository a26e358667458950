"""What the operator's files hold, before they are opened."""

from pathlib import Path

import numpy as np
from bags import bag

from imitate.rgbd import Intrinsics
from imitate.tui.files import look, read

FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"
MILLISECONDS = "its times are milliseconds since 1970 and read as such; time_unit in a mapping says otherwise"


def test_how_the_times_of_a_demonstration_are_read_is_said(tmp_path: Path) -> None:
    with np.load(FIXTURE) as held:
        np.savez(tmp_path / "ms.npz", **{**held, "t": 1000 * (held["t"] + 1.7e9)})
    assert look(tmp_path / "ms.npz").wrong == (MILLISECONDS,)
    notes: list[str] = []
    assert read(tmp_path / "ms.npz", notes).t[0] == 0
    assert notes == [MILLISECONDS]
    assert look(FIXTURE).wrong == ()


def test_what_a_recording_lost_is_said(tmp_path: Path) -> None:
    with bag(tmp_path / "film.mcap") as made:
        made.info("/c/camera_info", Intrinsics(64, 48, 60, 60, 31.5, 23.5))
        for k in range(20):
            made.image("/c/depth", np.full((48, 64), 1000, np.uint16), "16UC1", 100 + k / 10)
            made.image("/c/colour", np.full((48, 64, 3), 200, np.uint8), "rgb8", 100 + k / 10 - 30 * (k == 7))
    assert look(tmp_path / "film.mcap").wrong == (
        "1 of 20 pictures of /c/colour is left out: stamped more than 1 s off those before and after",
    )
