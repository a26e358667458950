"""What is filmed: drawn around what moves as if it were drawn whole, from where it was asked, in any room."""

import numpy as np
import pytest

from imitate.errors import SceneError
from imitate.geometry import angle_between
from imitate.settings import Perception
from imitate.world.demonstrator import FRONT, Viewpoint, draw_viewpoint, film, plan_film, visible
from imitate.world.kinect import Light, project, render
from imitate.world.look import Look, draw_look
from imitate.world.sensor import AXIAL, KINECT
from imitate.world.stage import paints, stage
from imitate.world.tasks import make_up

HAND = Perception()


def planned(task="stack", look=None, viewpoint=FRONT, sensor=AXIAL, rate=2.0):
    return plan_film(make_up(task, 1), 160, 120, rate, viewpoint, sensor, look)


def test_what_is_drawn_in_parts_is_the_whole_picture():
    plan = planned()
    with stage(plan.performance, plan.camera, HAND, plan.look) as scene:
        for k in (0, 5):
            part = scene.view(k)
            scene.place(k)
            whole = render(scene._client, plan.camera, plan.look.lights)
            assert (np.abs(part.colour - whole.colour).max(axis=-1) > 3).mean() < 0.001
            assert (np.abs(part.depth - whole.depth) > 1e-4).mean() < 0.001


@pytest.mark.parametrize("seed", range(4))
def test_camera_stands_where_it_was_drawn_and_sees_everything_in_the_middle(seed):
    viewpoint = draw_viewpoint(np.random.default_rng(seed))
    assert 30 <= viewpoint.elevation <= 70 and 0.7 <= viewpoint.distance <= 1.2
    plan = planned("three", viewpoint=viewpoint)
    d = plan.performance.demonstration
    points = np.concatenate([d.hand[:, :3], d.objects[..., :3].reshape(-1, 3)])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    (column, row, depth), *_ = project(plan.camera, middle[None])
    assert (column, row) == pytest.approx((79.5, 59.5), abs=1)
    assert depth == pytest.approx(viewpoint.distance, abs=0.01)
    seen = project(plan.camera, points)
    assert np.all((seen[:, :2] > 5) & (seen[:, :2] < [155, 115]))


def test_roll_turns_the_picture():
    straight, rolled = (planned(viewpoint=Viewpoint(10, 45, 0.8, roll)).camera for roll in (0, 8))
    turned = angle_between(straight.world_from_camera, rolled.world_from_camera)
    assert turned == pytest.approx(np.deg2rad(8))


def test_a_lamp_with_shade_darkens_the_table_beside_a_block():
    light = Light(direction=(0, -1.0, 1.0), shade=0.5)
    plain, shaded = planned(look=Look((Light(direction=(0, -1.0, 1.0)),))), planned(look=Look((light,)))
    bright, dark = (next(iter(film(plan, HAND, 0))).colour.astype(int) for plan in (plain, shaded))
    darker = (dark < 0.65 * bright).all(axis=-1)
    assert 30 < darker.sum() < 0.1 * darker.size


def test_grain_is_on_the_table_alone_and_follows_its_seed():
    def first(look):
        return next(iter(film(planned(look=look), HAND, 0))).colour.astype(int)

    bare, wood, same, other = (
        first(Look(grain=g, seed=s)) for g, s in ((0, 1), (0.15, 1), (0.15, 1), (0.15, 2))
    )
    np.testing.assert_array_equal(wood, same)
    changed = np.abs(wood - bare).max(axis=-1) > 4
    assert 0.2 < changed.mean() < 0.95 and not np.array_equal(wood, other)
    painted = bare.max(axis=-1) > 2.5 * bare.min(axis=-1)
    assert painted.sum() > 50 and not changed[painted].any()


def test_a_wall_stands_behind_what_the_camera_looks_at():
    low = Viewpoint(0, 30, 0.9)
    bare, walled = (next(iter(film(planned(look=Look(wall=w), viewpoint=low), HAND, 0))) for w in (0, 0.8))
    upper = np.s_[:12]
    assert np.median(walled.depth[upper]) < np.median(bare.depth[upper]) - 0.1 or not bare.depth[upper].any()
    assert 1 < np.median(walled.depth[upper]) < 2.6


def test_an_open_box_is_hollow():
    plan = planned("box", viewpoint=Viewpoint(0, 70, 0.8))
    tray = plan.performance.demonstration.objects[0, 1]
    column, row, depth = project(plan.camera, tray[None, :3])[0]
    frame = next(iter(film(plan, HAND, 0)))
    height = plan.performance.demonstration.object_sizes[1, 2]
    assert frame.depth[round(row), round(column)] > depth + height / 4 - 0.004


def test_shares_in_view_tell_what_hides_what():
    plan = planned("stack", rate=4)
    d = plan.performance.demonstration
    held = int(plan.performance.segments[1].start * 4) + 3
    shares = visible(plan, HAND, np.array([0, held]))
    assert shares.shape == (2, 3) and np.all((shares >= 0) & (shares <= 1))
    assert np.all(shares[0] > 0.95)
    assert shares[1, 1] < 0.95  # the fingers are before the block that they hold
    assert len(d.t) > held


def test_an_arm_goes_with_the_fingers_and_hides_what_is_behind_it():
    bare, armed = planned(), planned(look=Look(arm=True))
    for k in (0, 6):
        first, second = (list(film(plan, HAND, 0))[k] for plan in (bare, armed))
        more = second.depth < first.depth - 0.02
        assert 150 < more.sum() < 0.3 * more.size
        skin = np.abs(second.colour.astype(int) - [160, 120, 95]).max(axis=-1) < 60
        assert (skin & more).sum() > 20
    shares = [visible(plan, HAND, np.array([0]))[0, 0] for plan in (bare, armed)]
    assert 0.6 < shares[1] <= shares[0]


def test_rooms_are_drawn_by_seed():
    one, same, other = (draw_look(np.random.default_rng(seed)) for seed in (0, 0, 1))
    assert one == same != other
    plan = planned(look=one, sensor=KINECT)
    a, b = (next(iter(film(plan, HAND, 5))) for _ in range(2))
    np.testing.assert_array_equal(a.colour, b.colour)
    np.testing.assert_array_equal(a.depth, b.depth)


def test_objects_wear_the_paint_that_they_are_called_by():
    assert paints(("purple", "green")) == ("purple", "green")
    assert paints(("cubeA", "cubeB")) == ("blue", "green")
    with pytest.raises(SceneError, match="5 objects, and paint for 4"):
        paints(("a", "b", "c", "d", "e"))
