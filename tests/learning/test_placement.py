"""Where objects are to end, and when they do."""

from dataclasses import replace

import numpy as np
import pytest
from records import moved, still

from imitate.geometry import relative
from imitate.learning.placement import displaced, misplaced, placements, resting
from imitate.settings import Settings

LEARNING = Settings().learning
NAMES = ("cubeA", "cubeB")


def test_each_carried_object_has_its_place_relative_to_its_reference(stacking):
    demonstration, segments = stacking
    (place,) = placements(demonstration, segments)
    shown = relative(demonstration.objects[-1, 1], demonstration.objects[-1, 0])[:3]
    assert (place.name, place.reference, place.left) == ("cubeA", "cubeB", True)
    assert np.allclose(place.position, shown, atol=1e-3)


def test_an_object_still_carried_at_the_end_may_be_held(stacking):
    demonstration, segments = stacking
    (place,) = placements(demonstration, segments[:1])
    assert not place.left


def test_an_object_carried_over_the_table_has_its_place_there(stacking):
    demonstration, (carry, retreat) = stacking
    lifted = replace(carry, abstraction=replace(carry.abstraction, reference="table"))
    wanted = placements(demonstration, (lifted, retreat))
    assert np.allclose(wanted[0].position, demonstration.objects[-1, 0, :3], atol=1e-3)
    record = still(demonstration)
    assert misplaced(record, NAMES, wanted, LEARNING) == ""
    assert misplaced(moved(record, 1, [0.1, 0, 0]), NAMES, wanted, LEARNING) == ""
    away = misplaced(moved(record, 0, [0, 0.03, 0]), NAMES, wanted, LEARNING)
    assert away == "cubeA ends 30 mm from its place relative to table"


def test_misplaced_says_what_is_wrong(stacking):
    demonstration, segments = stacking
    wanted = placements(demonstration, segments)
    record = still(demonstration)
    assert misplaced(record, NAMES, wanted, LEARNING) == ""
    away = moved(record, 0, [0.05, 0, 0])
    assert misplaced(away, NAMES, wanted, LEARNING) == "cubeA ends 50 mm from its place relative to cubeB"
    touched = replace(record, contact_forces=np.ones_like(record.contact_forces))
    assert misplaced(touched, NAMES, wanted, LEARNING) == "the gripper still touches cubeA"


def test_displaced_is_what_was_off_before_the_last_option_started(stacking):
    demonstration, segments = stacking
    wanted, record = placements(demonstration, segments), still(demonstration)
    off = moved(record, 0, [0.05, 0, 0]).object_poses
    turns = replace(record, option_starts=(0, 240))
    knocked = replace(turns, object_poses=np.concatenate([record.object_poses[:300], off[300:]]))
    inherited = replace(turns, object_poses=np.concatenate([record.object_poses[:200], off[200:]]))
    assert [displaced(r, NAMES, wanted, LEARNING) for r in (turns, knocked, inherited)] == [
        False,
        False,
        True,
    ]
    assert misplaced(knocked, NAMES, wanted, LEARNING) == misplaced(inherited, NAMES, wanted, LEARNING) != ""


def test_moving_both_objects_together_keeps_the_place(stacking):
    demonstration, segments = stacking
    both = moved(moved(still(demonstration), 0, [0.2, 0.1, 0]), 1, [0.2, 0.1, 0])
    assert misplaced(both, NAMES, placements(demonstration, segments), LEARNING) == ""


@pytest.mark.parametrize(
    ("off", "physics", "camera"), [(0.001, True, True), (0.004, False, True), (0.006, False, False)]
)
def test_a_body_rests_within_what_each_way_of_knowing_can_tell(off, physics, camera):
    poses = np.tile([0.0, 0, 0, 0, 0, 0, 1], (100, 1))
    poses[80:, 0] = off
    for observe_trials, rests in ((False, physics), (True, camera)):
        settings = LEARNING.model_copy(update={"observe_trials": observe_trials})
        assert resting(poses, 1 / 240, settings) == rests
