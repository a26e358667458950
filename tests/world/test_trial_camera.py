"""The camera before trials: where it stands, what it shows, and that physics does not notice."""

from dataclasses import replace

import numpy as np
import pytest

from imitate.errors import SceneError
from imitate.geometry import from_yaw
from imitate.settings import Settings
from imitate.world.kinect import project
from imitate.world.scene import scene_of
from imitate.world.trial_camera import GREY, PAINTS, TrialCamera, stand, trial_paints


@pytest.fixture(scope="module")
def spec(short_demonstration):
    return scene_of(short_demonstration, Settings().world)


@pytest.fixture(scope="module")
def camera(spec):
    made = TrialCamera(spec, 160)
    yield made
    made.close()


def picture(camera, spec, objects, seed=0):
    return camera.picture(0.0, spec.home, objects, np.random.default_rng(seed))


def test_it_stands_opposite_the_robot_and_looks_down_on_the_objects(camera, spec):
    place = camera.camera.world_from_camera
    middle = spec.object_poses[:, :3].mean(axis=0)
    assert (place[:2] - middle[:2]) @ (spec.base[:2] - middle[:2]) < 0
    assert place[2] > 0.5
    u, v, _ = project(camera.camera, middle[None])[0]
    assert (u, v) == pytest.approx((79.5, 59.5), abs=1)


def test_it_steps_back_from_objects_that_stand_far_apart(spec):
    middle = spec.object_poses[:, :3].mean(axis=0)
    apart = middle + 3 * (spec.object_poses[:, :3] - middle) + [[0.2, 0, 0], [-0.2, 0, 0]]
    wide = replace(spec, object_poses=from_yaw(apart, np.zeros(2)))
    assert np.linalg.norm(stand(wide)[:3] - middle) > np.linalg.norm(stand(spec)[:3] - middle)


def test_an_object_is_drawn_where_it_is_and_the_robot_without_colour(camera, spec):
    # Towards the camera, and one to either side: away from the hand, which has the first between its fingers.
    objects, away = spec.object_poses.copy(), camera.camera.world_from_camera[:2] - spec.base[:2]
    away /= np.linalg.norm(away)
    objects[:, :2] = spec.object_poses[:, :2].mean(axis=0) + 0.15 * away
    objects[:, :2] += 0.1 * np.array([[-away[1], away[0]], [away[1], -away[0]]])
    frame = picture(camera, spec, objects)
    blue, green = (frame.colour.argmax(axis=2) == k for k in (2, 1))
    coloured = np.ptp(frame.colour.astype(int), axis=2) > 60
    for own, pose in zip((blue & coloured, green & coloured), objects, strict=True):
        rows, columns = np.nonzero(own)
        assert len(rows) > 20
        u, v, _ = project(camera.camera, pose[None, :3])[0]
        assert (columns.mean(), rows.mean()) == pytest.approx((u, v), abs=3)


def test_the_same_seed_gives_the_same_picture(camera, spec):
    first, other = (picture(camera, spec, spec.object_poses, seed) for seed in (1, 2))
    moved = spec.object_poses + np.array([0.1, 0, 0, 0, 0, 0, 0])
    picture(camera, spec, moved)
    again = picture(camera, spec, spec.object_poses, 1)
    assert again.depth.tobytes() == first.depth.tobytes() != other.depth.tobytes()
    assert again.colour.tobytes() == first.colour.tobytes()


def test_the_robot_before_an_object_is_grey_and_read_where_it_is(camera, spec):
    hand = short_of(camera, spec)
    frame = picture(camera, spec, hand)
    grey = np.all(frame.colour == GREY, axis=2)
    assert grey.sum() > 50
    assert np.all(frame.depth[grey] > 0)


def short_of(camera, spec):
    """Objects behind the robot's hand as the camera sees it, so that the hand is in what is drawn."""
    objects = spec.object_poses.copy()
    eye = camera.camera.world_from_camera[:3]
    camera._place(spec.home, objects)
    link = camera._client.getLinkState(camera._body.number, camera._body.hand)
    hand = np.array(link[0])
    objects[0, :3] = hand + 0.1 * (hand - eye) / np.linalg.norm(hand - eye)
    return objects


def test_every_object_has_a_paint_of_its_own_while_there_are_some():
    assert trial_paints(("green", "blue")) == ("green", "blue")
    assert trial_paints(("cube", "plate")) == ("blue", "green")
    assert len(set(trial_paints(tuple("abcdef")))) == 6
    with pytest.raises(SceneError, match=f"7 objects, and {len(PAINTS)} paints .* without --observe-trials"):
        trial_paints(tuple("abcdefg"))
