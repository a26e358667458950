"""Hues by name."""

import colorsys

import numpy as np
import pytest

from imitate.errors import UnknownNameError
from imitate.perception.colour import HUES, dominant_hue, hues, is_hue


def picture(*degrees, saturation=0.9):
    colours = [colorsys.hsv_to_rgb(d / 360, saturation, 0.8) for d in degrees]
    return np.round(255 * np.array([colours])).astype(np.uint8)


def test_every_hue_has_one_name():
    around = np.arange(0, 360, 0.5, dtype=np.float32)
    assert np.all(sum(is_hue(around, name).astype(int) for name in HUES) == 1)


@pytest.mark.parametrize(
    ("degrees", "name"),
    [(2, "red"), (358, "red"), (54, "yellow"), (125, "green"), (225, "blue"), (280, "purple")],
)
def test_paints_are_called_what_people_call_them(degrees, name):
    found = hues(picture(degrees))
    assert abs((found[0, 0] - degrees + 180) % 360 - 180) < 3
    assert dominant_hue(found[0]) == name


def test_grey_has_no_hue():
    found = hues(picture(30, 225, saturation=0.15))
    assert np.isnan(found).all()
    assert dominant_hue(found[0]) == "grey"


def test_unknown_hue_lists_the_known():
    with pytest.raises(UnknownNameError, match=r"unknown hue 'bleu'. Did you mean 'blue'"):
        is_hue(np.zeros(1, np.float32), "bleu")
