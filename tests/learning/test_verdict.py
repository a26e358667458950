"""Whether a trial did what was shown: nothing that learning does bends it, and doing nothing never passes."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from records import done, moved
from test_places import STAYED, carried, shown

from imitate.demonstration import Demonstration
from imitate.geometry import compose, from_yaw
from imitate.learning.places import places
from imitate.learning.problem import formulate
from imitate.learning.verdict import displaced, verdict
from imitate.record import Start
from imitate.settings import Settings
from imitate.skill import Abstraction, Formulation, Segment

SETTINGS = Settings()
LEARNING = SETTINGS.learning


def words(demonstration, segments, record):
    asked = places(demonstration, segments, LEARNING)
    return [m.words for m in verdict(asked, record, demonstration.object_names, LEARNING)]


def started(demonstration, poses):
    """A trial in which nothing moves from these poses (K, 7)."""
    record = done(replace(demonstration, objects=np.repeat(poses[None], len(demonstration.t), axis=0)))
    return replace(record, start=Start(np.zeros(9), poses))


def test_what_ends_as_shown_passes_and_what_does_not_is_said(stacking):
    demonstration, segments = stacking
    record = done(demonstration)
    assert words(demonstration, segments, record) == []
    off = moved(record, 0, [0.05, 0, 0])
    assert words(demonstration, segments, off) == ["cubeA ends 50 mm from its place relative to cubeB"]
    touched = replace(record, contact_forces=np.ones_like(record.contact_forces))
    assert words(demonstration, segments, touched) == ["the gripper still touches cubeA"]
    poses = record.object_poses.copy()
    poses[-20:, 0, 2] += np.linspace(0, 0.01, 20)
    assert words(demonstration, segments, replace(record, object_poses=poses)) == ["cubeA is still moving"]


def test_moving_both_keeps_the_place_and_moves_what_was_to_stay(stacking):
    demonstration, segments = stacking
    both = moved(moved(done(demonstration), 0, [0.2, 0.1, 0]), 1, [0.2, 0.1, 0])
    assert words(demonstration, segments, both) == ["cubeB was moved by 224 mm, and was shown to stay"]


def test_what_was_to_stay_may_not_be_tipped_over(stacking):
    demonstration, segments = stacking
    record = done(demonstration)
    poses = record.object_poses.copy()
    poses[:, 1] = compose(poses[:, 1], [0, 0, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    *_, said = words(demonstration, segments, replace(record, object_poses=poses))
    assert said == "cubeB was turned by 90°, and was shown to stay"


def test_a_lifted_cube_has_to_be_up():
    lift = shown(((0, 0, 0.033), 0), STAYED)
    segments = carried("a", reference="table")
    assert words(lift, segments, done(lift)) == []
    assert words(lift, segments, moved(done(lift), 0, [0, 0, -0.017])) == [
        "a ends 17 mm from its place relative to table (16 mm allowed, half of what was shown)"
    ]


def test_a_knob_has_to_be_turned():
    knob = shown(((0, 0, 0), 1.0), STAYED)
    assert words(knob, carried("a"), done(knob)) == []
    assert words(knob, carried("a"), started(knob, knob.objects[0])) == [
        "a ends turned by 57° from its place relative to b"
    ]


def test_what_starts_at_its_place_has_to_be_moved_all_the_same():
    push = shown(((0.03, 0, 0), 0), STAYED)
    there = push.objects[-1].copy()
    assert words(push, carried("a", reference="table"), started(push, there)) == ["a was hardly moved"]


def test_what_was_displaced_before_the_last_option_is_told_from_what_it_did(stacking):
    demonstration, segments = stacking
    asked, record = places(demonstration, segments, LEARNING), done(demonstration)
    off = moved(record, 0, [0.05, 0, 0]).object_poses
    turns = replace(record, option_starts=(0, 240))
    knocked = replace(turns, object_poses=np.concatenate([record.object_poses[:300], off[300:]]))
    inherited = replace(turns, object_poses=np.concatenate([record.object_poses[:200], off[200:]]))
    names = demonstration.object_names
    assert [displaced(asked, r, names) for r in (turns, knocked, inherited)] == [False, False, True]
    assert words(demonstration, segments, knocked) == words(demonstration, segments, inherited) != []


SHIFT = st.tuples(*[st.floats(-0.3, 0.3)] * 3)
START = st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.8, 0.8))
MOTION = st.one_of(st.just(STAYED), st.tuples(SHIFT, st.floats(-1.5, 1.5)))
NAMES = st.sampled_from(["a", "b", "c"])
ABSTRACTION = st.tuples(st.sets(NAMES, max_size=2), st.sampled_from(["a", "b", "c", "table"]))


def abstraction(drawn):
    relevant, reference = drawn
    return Abstraction(("hand", *sorted(relevant - {reference})), reference)


@given(
    motions=st.lists(MOTION, min_size=3, max_size=3),
    cut=st.floats(0.3, 1.7),
    labels=st.tuples(ABSTRACTION, ABSTRACTION),
    stated=st.tuples(ABSTRACTION, ABSTRACTION),
    start=st.lists(START, min_size=3, max_size=3),
)
def test_doing_nothing_fails_whatever_is_segmented_stated_or_accepted(motions, cut, labels, stated, start):
    d: Demonstration = shown(*motions)
    segments = tuple(
        Segment(a, b, abstraction(label)) for a, b, label in zip((0.0, cut), (cut, 2.0), labels, strict=True)
    )
    asked = places(d, segments, LEARNING)
    for i, label in enumerate(stated):
        formulate(d, segments, Formulation(i, 0, abstraction(label), ("pose", "gripper"), ""), SETTINGS)
    again = places(d, segments, LEARNING)
    assert [p.name for p in asked] == [p.name for p in again] == list(d.object_names)
    assert all(np.array_equal(p.pose, q.pose) and p.near == q.near for p, q in zip(asked, again, strict=True))
    poses = d.objects[0].copy()
    for k, (x, y, yaw) in enumerate(start):
        poses[k] = from_yaw(poses[k, :3] + [x, y, 0], yaw)
    far = np.linalg.norm(d.objects[-1, :, :3] - d.objects[0, :, :3], axis=1)
    failed = verdict(asked, started(d, poses), d.object_names, LEARNING)
    if far.max() > 0.0051:
        assert failed
    if not np.any(d.objects != d.objects[0]):
        assert not failed
