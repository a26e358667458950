"""Made-up tasks: nothing sinks into the table, what is held goes along, skills follow each other."""

import numpy as np
import pytest

from imitate.demonstration import HAND
from imitate.geometry import relative, rotate
from imitate.world.tasks import TASKS, make_up

ALL = [(task, seed) for task in TASKS for seed in range(6)]


@pytest.mark.parametrize(("task", "seed"), ALL)
def test_held_objects_go_along_and_others_stay(task, seed):
    p = make_up(task, seed)
    d = p.demonstration
    for s in p.segments:
        inside = (d.t >= s.start) & (d.t <= s.end)
        for name in d.object_names:
            poses = d.pose_of(name)[inside]
            moved = np.linalg.norm(np.ptp(poses[:, :3], axis=0))
            if name in s.abstraction.carried:
                assert moved > 0.08
                held = relative(d.hand, d.pose_of(name))[(d.t > s.start + 0.3) & (d.t < s.end - 0.3)]
                assert np.ptp(held[:, :3], axis=0).max() < 1e-9
            else:
                assert moved < 0.005, (name, s)


@pytest.mark.parametrize(("task", "seed"), ALL)
def test_nothing_is_below_the_table_and_blocks_end_upright_on_something(task, seed):
    d = make_up(task, seed).demonstration
    for k, size in enumerate(d.object_sizes):
        corners = size / 2 * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        lowest = (rotate(d.objects[:, k, None, 3:], corners) + d.objects[:, k, None, :3])[..., 2].min()
        assert lowest > -1e-6
        assert rotate(d.objects[-1, k, 3:], [0, 0, 1.0])[2] == pytest.approx(1)
    assert d.hand[:, 2].min() > 0.005


@pytest.mark.parametrize(("task", "seed"), ALL)
def test_moves_as_a_person_does(task, seed):
    p = make_up(task, seed)
    d = p.demonstration
    speed = np.linalg.norm(np.gradient(d.hand[:, :3], d.t, axis=0), axis=1)
    assert speed[:40].max() < 1e-6 and speed[-20:].max() < 1e-6
    assert 0.25 < speed.max() < 1.2
    assert np.linalg.norm(np.diff(d.hand[:, :3], 3, axis=0) / 0.01**3, axis=1).max() < 100  # m/s³
    assert 4 < d.duration < 14
    assert np.all(p.opening >= 0) and p.opening.max() <= 0.08 + 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_skills_follow_each_other(seed):
    for task in TASKS:
        p = make_up(task, seed)
        ends = [0.0, *(s.end for s in p.segments)]
        assert [s.start for s in p.segments] == ends[:-1]
        assert ends[-1] == pytest.approx(p.demonstration.duration, abs=0.02)
        carries = [s.abstraction for s in p.segments[1::2]]
        reaches = [s.abstraction for s in p.segments[::2]]
        assert all(a.relevant == (HAND,) for a in reaches)
        assert [a.carried[0] for a in carries] == [a.reference for a in reaches[:-1]]
        assert reaches[-1].reference == carries[-1].carried[0]


def test_tasks_end_as_they_are_called():
    for seed in range(5):
        p = make_up("box", seed)
        block, tray = p.demonstration.objects[-1]
        inner = p.demonstration.object_sizes[1, :2] / 2
        assert p.hollow == (p.demonstration.object_names[1],)
        assert np.all(np.abs(relative(tray, block)[:2]) < inner - 0.03)
        on, under = make_up("stack", seed).demonstration.objects[-1]
        assert np.linalg.norm((on - under)[:2]) < 0.01 < on[2] - under[2]
        first, last = make_up("unstack", seed).demonstration.objects[[0, -1], 0]
        assert first[2] > last[2] + 0.03
        pushed = make_up("push", seed).demonstration.objects[:, 0]
        assert np.ptp(pushed[:, 2]) < 1e-9


def test_a_seed_is_one_performance_and_others_differ():
    one, same, other = (make_up("stack", seed).demonstration for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.hand, same.hand)
    assert one.hand.shape != other.hand.shape or not np.array_equal(one.hand, other.hand)
    assert {len(make_up("three", seed).segments) for seed in range(8)} == {3, 5}
