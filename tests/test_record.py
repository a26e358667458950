"""What is believed of a trial: everything where it was seen last."""

import numpy as np
import recorded
from hypothesis import given
from hypothesis import strategies as st

from imitate.record import Sightings, as_seen

NAN = np.full(7, np.nan)


def at(x):
    return np.array([x, 0, 0, 0, 0, 0, 1.0])


def sightings(*rows, steps=None):
    """Two objects expected at 0 and −1, then seen at these x, or not where None."""
    poses = np.array([[NAN if x is None else at(x) for x in row] for row in rows])
    return Sightings(np.array([at(0), at(-1)]), tuple(steps or range(len(rows))), poses)


def test_what_is_not_seen_is_where_it_was_seen_last():
    seen = sightings((None, 1), (2, None), (None, None), (4, 5))
    assert np.array_equal(seen.believed[..., 0], [[0, -1], [0, 1], [2, 1], [2, 1], [4, 5]])
    assert seen.in_sight == (True, True)
    assert sightings((1, None)).in_sight == (True, False)


def test_a_record_as_seen_changes_at_the_looks_and_nowhere_else():
    record = recorded.record(40)
    seen = sightings((1, 1), (2, None), (3, 3), steps=(0, 10, 40))
    believed = as_seen(record, seen)
    x = believed.object_poses[..., 0]
    assert x[:9, 0].tolist() == [1.0] * 9  # after 1 … 9 steps
    assert x[9:39, 0].tolist() == [2.0] * 30
    assert x[-1].tolist() == [3.0, 3.0]
    assert set(x[:39, 1]) == {1.0}
    assert believed.start.objects[:, 0].tolist() == [1.0, 1.0]
    assert believed.hand_poses is record.hand_poses
    assert as_seen(record, None) is record


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=12))
def test_beliefs_are_never_without_a_pose_and_are_what_was_seen(shown):
    rows = [tuple(float(k + 1) if s else None for s in row) for k, row in enumerate(shown)]
    seen = sightings(*rows)
    assert not np.isnan(seen.believed).any()
    for k, row in enumerate(shown):
        for i, s in enumerate(row):
            if s:
                assert seen.believed[k + 1, i, 0] == k + 1
