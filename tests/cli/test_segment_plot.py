"""What the picture of a segmentation says: every skill, every object, every stretch not seen."""

from dataclasses import replace

import numpy as np
import pytest
from stacking import Stacking, perform

from imitate.cli.segment_plot import segment_figure
from imitate.segmentation import changes, segment
from imitate.settings import Segmentation


@pytest.fixture(scope="module")
def shown():
    demonstration, _ = perform(Stacking(objects=3), np.random.default_rng(0))
    objects = np.array(demonstration.objects)
    objects[40:70, 2] = np.nan
    return replace(demonstration, objects=objects)


def drawn(shown, segments):
    settings = Segmentation()
    return segment_figure(shown, segments, changes(shown, segments, settings), settings, "demo.npz")


def words(figure):
    return [text.get_text() for row in figure.axes for text in row.texts]


def test_skills_objects_units_and_what_was_not_seen(shown):
    segments = segment(shown, Segmentation())
    figure = drawn(shown, segments)
    assert len(words(figure)) == len(segments)
    for s, text in zip(segments, words(figure), strict=True):
        assert text.replace("\n", " ").split(maxsplit=1)[1] == str(s.abstraction)
    labels = [row.get_ylabel() for row in figure.axes]
    assert labels == [
        "skill",
        "hand to object (m)",
        "co-motion\n(nats a frame)",
        "change here\n(probability / s)",
        "not seen",
    ]
    assert [text.get_text() for text in figure.axes[4].get_yticklabels()] == [shown.object_names[2]]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(shown.object_names)
    lines = figure.axes[1].get_lines()[:3]
    assert len({line.get_linestyle() for line in lines} | {line.get_color() for line in lines}) > 3
    assert np.isnan(lines[2].get_ydata()[40:70]).all()


def test_a_band_too_narrow_for_words_has_its_number_and_the_words_stand_below(shown):
    first, *rest = segment(shown, Segmentation())
    narrow = (replace(first, end=first.start + 0.1), replace(first, start=first.start + 0.1), *rest)
    figure = drawn(shown, narrow)
    assert words(figure)[0] == "1"
    assert figure.legends[0].get_texts()[-1].get_text() == f"1  {first.abstraction}"


def test_the_hands_opening_is_drawn_where_it_was_seen(shown):
    segments = segment(shown, Segmentation())
    opening = np.linspace(0.08, 0.05, len(shown.t))
    row = drawn(replace(shown, opening=opening), segments).axes[1]
    (line,) = [line for line in row.get_lines() if line.get_label() == "opening of the hand"]
    np.testing.assert_array_equal(line.get_ydata(), opening)
