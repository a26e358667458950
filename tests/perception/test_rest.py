"""What rests is averaged, what moves is followed at once, what creeps soon; and what is usual of a fit."""

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import angle_between
from imitate.perception.rest import CREPT, Rest
from imitate.perception.usual import Usual

START = np.array([0.1, 0.2, 0.03, 0, 0, 0, 1.0])


def measured(pose, generator, noise=0.0003):
    turn = Rotation.from_rotvec(generator.normal(0, 0.004, 3)) * Rotation.from_quat(pose[3:])
    return np.concatenate([pose[:3] + generator.normal(0, noise, 3), turn.as_quat()])


def test_at_rest_the_estimate_is_better_than_any_measurement():
    generator, rest, pose = np.random.default_rng(0), Rest(), START
    off = []
    for _ in range(40):
        pose = rest.settled(pose, measured(START, generator))
        off.append(np.linalg.norm(pose[:3] - START[:3]))
    assert rest.frames >= 30
    assert np.max(off[25:]) < 0.0002
    assert angle_between(pose, START) < 0.003


def test_a_jump_is_followed_at_once():
    generator, rest, pose = np.random.default_rng(1), Rest(), START
    for _ in range(20):
        pose = rest.settled(pose, measured(START, generator))
    there = START + np.array([0.004, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(rest.settled(pose, there), there)
    assert rest.frames == 0


def test_creeping_is_followed_with_less_than_a_millimetre_of_delay():
    generator, rest, pose = np.random.default_rng(2), Rest(), START
    late = []
    for k in range(120):
        real = START + np.array([0.0002 * max(0, k - 20), 0, 0, 0, 0, 0, 0])
        pose = rest.settled(pose, measured(real, generator, 0.0001))
        late.append(np.linalg.norm(pose[:3] - real[:3]))
    assert max(late) < 2.5 * CREPT


def test_only_what_noise_does_not_explain_is_worse_than_usual():
    generator, usual = np.random.default_rng(3), Usual()
    assert not usual.is_worse(-100)  # nothing is known yet
    for score in generator.normal(-0.5, 0.1, 60):
        usual.learn(float(score), 0.8)
    assert usual.is_worse(-1.2) and not usual.is_worse(-0.7)
    assert usual.relative(0.4) == 0.5 and usual.relative(0.9) == 1


def test_one_bad_frame_hardly_changes_what_is_usual():
    usual = Usual()
    for _ in range(30):
        usual.learn(-0.5, 0.9)
    before = usual.mean
    usual.learn(-4.0, 0.3)
    assert before - usual.mean < 0.02 and usual.is_worse(-1.0)
