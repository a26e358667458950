"""The fingers' colours: named, given, picked; and fingers told from patches of their colour."""

import colorsys
import json

import cv2
import numpy as np
import pytest

from imitate.cli import main
from imitate.errors import UsageError
from imitate.formats.recordings import open_recording
from imitate.perception.colour import is_hue
from imitate.perception.fingers import LEFT, RIGHT, finger_colours, worn
from imitate.perception.observe import observe
from imitate.settings import Perception, Settings


def rgb(hue, saturation=0.85, value=0.75):
    return tuple(round(255 * c) for c in colorsys.hsv_to_rgb(hue / 360, saturation, value))


def picture(left, right, background=(150, 140, 135), noise=6, seed=0):
    """(160, 240, 3) with a finger of each colour, upright and slanted, each with a highlight along it."""
    drawn = np.full((160, 240, 3), background, np.uint8)
    cv2.rectangle(drawn, (140, 100), (190, 140), rgb(220), -1)
    cv2.line(drawn, (60, 20), (70, 90), left, 13)
    cv2.line(drawn, (110, 20), (105, 90), right, 13)
    cv2.line(drawn, (62, 30), (67, 70), (252, 250, 251), 3)
    cv2.line(drawn, (109, 30), (107, 70), (252, 250, 251), 3)
    shade = np.linspace(1.1, 0.7, 240)[None, :, None]
    noisy = drawn * shade + noise * np.random.default_rng(seed).standard_normal(drawn.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def masks():
    left, right = np.zeros((160, 240), np.uint8), np.zeros((160, 240), np.uint8)
    cv2.line(left, (60, 20), (70, 90), 1, 13)
    cv2.line(right, (110, 20), (105, 90), 1, 13)
    return left > 0, right > 0


PAIRS = [(0, 55), (350, 30), (300, 130), (95, 60), (340, 10)]


@pytest.mark.parametrize(("left", "right"), PAIRS)
@pytest.mark.parametrize("saturation", [0.9, 0.35])
def test_picked_fingers_are_found_whole_and_alone(left, right, saturation):
    shown = picture(rgb(left, saturation), rgb(right, saturation))
    colours = finger_colours(Perception(left_finger="62,80", right_finger="106,85"), shown)
    sides = colours.sides(shown)
    for side, real in zip((LEFT, RIGHT), masks(), strict=True):
        found = sides == side
        assert np.sum(found & real) > 0.9 * real.sum()
        assert np.sum(found & ~real) < 0.1 * real.sum()


def test_a_given_colour_is_found_where_it_differs_a_little():
    shown = picture(rgb(8), rgb(50))
    colours = finger_colours(Perception(left_finger="#c8201e", right_finger="#d0b020"), shown)
    sides = colours.sides(shown)
    for side, real in zip((LEFT, RIGHT), masks(), strict=True):
        assert np.sum((sides == side) & real) > 0.9 * real.sum()


def test_skin_of_a_like_hue_is_told_by_its_saturation():
    skin = rgb(14, 0.4, 0.8)
    shown = picture(rgb(5, 0.9), rgb(60), background=skin)
    colours = finger_colours(Perception(left_finger="62,80", right_finger="106,85"), shown)
    real = masks()[0]
    found = colours.sides(shown) == LEFT
    assert np.sum(found & real) > 0.85 * real.sum() and np.sum(found & ~real) < 0.05 * real.sum()


def test_hues_by_name_need_no_picture_and_are_what_they_were():
    shown = picture(rgb(0), rgb(55), noise=0)
    colours = finger_colours(Perception())
    hues = colours.hues(shown)
    assert is_hue(hues, "left finger").sum() >= masks()[0].sum()
    assert not is_hue(hues, "red").any() and is_hue(hues, "blue").any()


@pytest.mark.parametrize(
    ("left", "words"),
    [
        ("bleu", "not a colour. Valid: a hue .*yellow.*'#c81e1e', or a pixel of the first picture as 'U,V'"),
        ("240,3", "outside of the picture, which is 240 wide and 160 high"),
        ("20,20", "is grey. Point at the finger's coloured part"),
        ("#807f80", "is grey"),
        ("#20e0d0", "nothing in the first picture is near that colour"),
        ("106,85", "too alike to tell left from right"),
    ],
)
def test_what_cannot_be_a_colour_is_said(left, words):
    shown = picture(rgb(0), rgb(55))
    with pytest.raises(UsageError, match=words):
        finger_colours(Perception(left_finger=left, right_finger="105,80"), shown)


def test_a_pixel_without_a_picture_is_said():
    with pytest.raises(UsageError, match="there is no picture to look it up in"):
        finger_colours(Perception(left_finger="3,4"))


def cylinder(count, radius=0.009, length=0.08):
    g = np.random.default_rng(1)
    angle = g.uniform(0, np.pi, count)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), g.uniform(0, length, count)], axis=1)


def test_a_finger_is_worn_and_a_printed_stripe_is_not():
    g = np.random.default_rng(0)
    finger, front = (
        cylinder(400),
        np.column_stack([g.uniform(0.1, 0.3, 8000), np.zeros(8000), g.uniform(0, 0.2, 8000)]),
    )
    stripe = (np.abs(front[:, 0] - 0.2) < 0.009) & (front[:, 2] > 0.06) & (front[:, 2] < 0.13)
    points = np.concatenate([finger, front])
    sides = np.concatenate([np.full(400, LEFT), np.where(stripe, LEFT, 0)]).astype(np.int8)
    np.testing.assert_array_equal(worn(points, sides, Perception(), 0.001), np.arange(8400) < 400)


def test_a_block_of_a_fingers_colour_is_no_finger():
    g = np.random.default_rng(0)
    block = np.column_stack([g.uniform(0, 0.05, (2000, 2)), np.full(2000, 0.05)])
    assert not worn(block, np.full(2000, RIGHT, np.int8), Perception(), 0.001).any()


def test_a_picked_finger_is_followed_as_a_named_one(filmed, observed):
    """The first fourteen frames, fingers picked by the pixel nearest to the middle of each."""
    recording = open_recording(filmed.path)
    sides = finger_colours(Perception()).sides(next(iter(recording.frames())).colour)
    settings = {}
    for field, side in (("left_finger", LEFT), ("right_finger", RIGHT)):
        places = np.argwhere(sides == side)
        v, u = places[np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()]
        settings[field] = f"{u},{v}"
    seen = observe(filmed.path, Settings.model_validate({"perception": settings}), seed=3)
    apart = np.linalg.norm(seen.demonstration.hand[:, :3] - observed.demonstration.hand[:, :3], axis=1)
    assert np.median(apart) < 0.002 and np.nanmax(apart) < 0.01


def test_a_wrong_colour_is_one_message_and_wrong_usage(filmed, tmp_path, capsys):
    file = tmp_path / "mine.toml"
    file.write_text('[perception]\nleft_finger = "bleu"\n')
    with pytest.raises(SystemExit) as end:
        main(["observe", str(filmed.path), "--settings", str(file), "--json"])
    said = capsys.readouterr()
    assert end.value.code == 2 and "left_finger = 'bleu': not a colour" in said.err
    assert said.out == "" or "error" in json.loads(said.out)
