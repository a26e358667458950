"""Noisy sensors never read the same twice: what repeats is no reading, and an outlier is no motion."""

from dataclasses import replace

import numpy as np
import pytest
from showing import TASKS
from tagged import BOARD, Tags, lifted, stacked, tagged, waving

from imitate.geometry import from_yaw
from imitate.segmentation import hasty, segment
from imitate.segmentation.outliers import outliers
from imitate.segmentation.readings import fresh, trembling
from imitate.segmentation.tracks import track_of
from imitate.settings import load_settings
from imitate.skill import Abstraction, Segment

ROBUST = load_settings().segmentation
T = np.arange(90) / 30
REAL = Tags()
"""as on the recording of a PR2: 2 cm, frozen while held, outliers of 26 cm."""
KINDS = {
    "every frame": REAL,
    "every third, repeated": replace(REAL, every=3),
    "every third, interpolated": replace(REAL, every=3, joined=True),
    "mostly covered": replace(REAL, covered=0.6, noise=0.01, every=3),
    "slow": replace(REAL, speed=0.35),
    "little noise": Tags(noise=0.002, turn_noise=0.01, frozen=False),
}


def resting(noise=0.02, seed=0):
    return from_yaw(np.random.default_rng(seed).normal(scale=noise, size=(len(T), 3)), np.zeros(len(T)))


def carries(demonstration):
    return [str(s.abstraction) for s in segment(demonstration, ROBUST) if s.abstraction.carried]


def test_repeated_and_interpolated_samples_are_no_readings():
    poses = resting()
    held = poses[np.arange(len(T)) // 3 * 3]
    assert np.flatnonzero(fresh(T, held)).tolist() == list(range(0, 90, 3))
    joined = poses.copy()
    joined[1::3], joined[2::3] = (
        (2 * poses[::3] + np.roll(poses[::3], -1, 0)) / 3,
        (poses[::3] + 2 * np.roll(poses[::3], -1, 0)) / 3,
    )
    assert np.flatnonzero(fresh(T[:88], joined[:88])).tolist() == list(range(0, 88, 3))


def test_noise_trembles_and_motion_does_not():
    assert trembling(T, resting()) == pytest.approx(0.02, rel=0.3)
    assert trembling(T, resting()[np.arange(90) // 6 * 6]) == pytest.approx(0.02, rel=0.5)
    quick = from_yaw(np.column_stack([np.sin(4 * T), T, 0 * T]), 0 * T)
    assert trembling(T, quick) == 0
    assert trembling(T, np.where((T < 1)[:, None], quick[0], quick)) == 0


def test_a_frozen_tag_is_unknown_and_its_noise_is_that_of_its_kind():
    frozen = resting()
    frozen[5:80] = frozen[4]
    track = track_of(T, frozen, ROBUST, 0.02)
    assert np.flatnonzero(~track.known).tolist() == list(range(5, 80))
    assert track_of(T, frozen, ROBUST).known[5:].all()  # as a body that rests in a simulation
    assert track_of(T, np.repeat(frozen[:1], 90, axis=0), ROBUST, 0.02).noise == 0.02


@pytest.mark.parametrize("frames", [slice(40, 41), slice(40, 46), slice(0, 4), slice(86, 90)])
def test_what_is_away_and_back_at_once_is_an_outlier(frames):
    poses = resting(0.005)
    poses[frames, :3] += [0.2, 0.1, 0.1]
    assert np.flatnonzero(outliers(T, poses, 0.005, ROBUST)).tolist() == list(range(90))[frames]


def test_a_motion_however_quick_is_none():
    way = np.clip((T - 1) / 0.3, 0, 1) - np.clip((T - 1.4) / 0.3, 0, 1)
    poses = resting(0.001)
    poses[:, 0] += 0.3 * way
    assert not outliers(T, poses, 0.001, ROBUST).any()
    jumped = resting(0.001)
    jumped[45:, 0] += 0.3
    assert not outliers(T, jumped, 0.001, ROBUST).any()


@pytest.mark.parametrize("kind", KINDS)
def test_tags_show_what_was_carried_and_never_the_board(kind):
    rng = np.random.default_rng(1)
    shown = stacked(rng)
    assert carries(tagged(shown, KINDS[kind], rng)) == ["⟨{hand, blue}, green⟩"]
    rng = np.random.default_rng(1)
    assert carries(tagged(waving(rng), KINDS[kind], rng)) == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_tags_over_many_seeds(kind):
    """Before, none to 11 of 20 stackings were right, and the board was carried in up to 11 of 20."""
    right = {}
    for task in (stacked, waving, TASKS["twice with a rest"], lifted):
        count = 0
        for seed in range(20):
            rng = np.random.default_rng(seed)
            shown = task(rng)
            found = carries(tagged(shown, KINDS[kind], rng))
            assert not any(BOARD in carry.split("}")[0] for carry in found)
            count += found == [skill for skill in shown.skills if "," in skill.split("}")[0]]
        right[task] = count
    assert right[waving] == 20 and right[stacked] >= 19 and right[TASKS["twice with a rest"]] >= 17, right


def test_a_carry_shorter_than_a_grasp_is_doubted():
    board = Abstraction(("hand", BOARD), "blue")
    segments = (
        Segment(0.0, 1.0, Abstraction(("hand",), "blue")),
        Segment(1.0, 1.4, board),
        Segment(1.4, 3.0, board),
    )
    (doubt,) = hasty(segments, ROBUST)
    assert str(doubt) == (
        "skill 2: ⟨{hand, board}, blue⟩ lasts 0.40 s, and fingers take 0.55 s to close and to open; it may "
        "be a push, or noise"
    )
