"""fixtures/stack.mcap, made by ``imitate demonstrate person -o fixtures/stack.mcap --size 320x240 --rate 12``
with ``--sensor axial``:
observed from its first frame to its last, against the person's motion that was filmed."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imitate.formats.recordings import open_recording, write_recording
from imitate.geometry import angle_between, compose, quaternion_multiply
from imitate.perception.observe import observe
from imitate.segmentation import segment
from imitate.settings import load_settings
from imitate.world.demonstrator import plan_film
from imitate.world.performance import perform

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture(scope="module")
def seen():
    calls = []
    observation = observe(FIXTURES / "stack.mcap", progress=lambda done, total: calls.append((done, total)))
    assert calls == [(k + 1, len(calls)) for k in range(len(calls))]
    return observation


@pytest.mark.parametrize("mode", ["robust", "faithful"])
def test_three_skills_of_the_paper(seen, mode):
    found = segment(seen.demonstration, load_settings(overrides={"mode": mode}).segmentation)
    assert [(s.abstraction.relevant, s.abstraction.reference) for s in found] == [
        (("hand",), "blue"),
        (("hand", "blue"), "green"),
        (("hand",), "blue"),
    ]
    assert 8 < found[0].end < 9.3 and 13.3 < found[1].end < 14.3


def test_within_three_millimetres_and_two_degrees(seen, human_stack):
    plan = plan_film(perform(human_stack), 320, 240, 12)
    real = plan.performance.demonstration
    world_from_table = compose(plan.camera.world_from_camera, seen.camera_from_table)
    tracks = {"hand": real.hand, "blue": real.objects[:, 0], "green": real.objects[:, 1]}
    for name, truth in tracks.items():
        found = compose(world_from_table, seen.demonstration.pose_of(name))
        away = np.linalg.norm(found[:, :3] - truth[:, :3], axis=1)
        assert np.median(away) < 0.0015 and away.max() < 0.004, name
        # a cube looks the same after any turn of the group
        turns = [[0, 0, 0, 1.0]] if name == "hand" else Rotation.create_group("O").as_quat()
        apart = [angle_between(quaternion_multiply(found[:, 3:], turn), truth) for turn in turns]
        assert min(np.median(a) for a in apart) < np.deg2rad(2), name
    assert seen.lost == {}


def test_sizes_are_right_to_a_millimetre_whatever_is_drawn(tmp_path):
    film = open_recording(FIXTURES / "stack.mcap")
    first = [frame for _, frame in zip(range(10), film.frames(), strict=False)]
    write_recording(tmp_path / "first.mcap", film.intrinsics, first)
    found = np.array(
        [
            observe(open_recording(tmp_path / "first.mcap"), seed=seed).demonstration.object_sizes
            for seed in range(5)
        ]
    )
    real = [[0.04] * 3, [0.05] * 3]
    np.testing.assert_allclose(np.median(found, axis=0), real, atol=0.001)
    np.testing.assert_allclose(found, np.tile(real, (5, 1, 1)), atol=0.003)  # one draw


def test_small_enough_to_keep():
    assert (FIXTURES / "stack.mcap").stat().st_size < 15e6
