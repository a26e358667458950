"""Lengths in other units than metres are never taken for metres, and the advice mends them."""

import re

import numpy as np
import pytest
import scripted

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.csv_file import write_csv
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.mapping import read_mapping
from imitate.formats.npz import write_npz


def scaled(positions=1.0, sizes=1.0):
    """The scripted demonstration in another unit."""
    d = scripted.demonstration()
    by = np.array([positions] * 3 + [1.0] * 4)
    return Demonstration(d.t, d.hand * by, d.objects * by, d.object_names, d.object_sizes * sizes)


@pytest.fixture(params=["npz", "csv"])
def written(request, tmp_path):
    """Writes a demonstration in either format; gives the file."""

    def write(demonstration):
        path = tmp_path / f"shown.{request.param}"
        if request.param == "csv":
            write_csv(demonstration, path)
        else:
            with path.open("wb") as stream:
                write_npz(demonstration, stream)
        return path

    return write


def refused(path, mapping=None):
    """What is said of the file, and a mapping of the line or lines that would mend it."""
    with pytest.raises(FileError) as error:
        read_demonstration(path, mapping)
    said = str(error.value)
    line = re.search(r"length_unit = \S+\"|\[objects\..*", said, re.DOTALL)
    assert line is not None, said
    advice = path.with_suffix(".toml")
    before = 'length_unit = "mm"\n' if mapping else ""
    advice.write_text(before + line[0])
    return said, read_mapping(advice)


@pytest.mark.parametrize(("factor", "word"), [(1000, "millimetres"), (100, "centimetres")])
def test_positions_in_another_unit(written, factor, word):
    path = written(scaled(factor, factor))
    said, mended = refused(path)
    assert "its positions lie" in said and "which cannot be metres" in said
    assert f"If they are {word}, say so in a mapping" in said
    read = read_demonstration(path, mended)
    assert np.allclose(read.hand, scripted.demonstration().hand)
    assert np.allclose(read.object_sizes, scripted.demonstration().object_sizes)


def test_sizes_in_millimetres_beside_positions_in_metres(written):
    path = written(scaled(1, 1000))
    said, mended = refused(path)
    assert "gives 'blue' a size of 40 × 40 × 40, which cannot be metres" in said
    assert np.allclose(read_demonstration(path, mended).object_sizes, scripted.demonstration().object_sizes)


def test_sizes_in_metres_beside_positions_in_millimetres(written):
    path = written(scaled(1000, 1))
    _, mended = refused(path)
    said, mended = refused(path, mended)
    assert "gives 'blue' a size of 4e-05 × 4e-05 × 4e-05" in said
    read = read_demonstration(path, mended)
    assert np.allclose(read.objects, scripted.demonstration().objects)
    assert np.allclose(read.object_sizes, scripted.demonstration().object_sizes)


def test_a_place_far_from_the_origin_is_no_other_unit(written):
    d = scaled()
    far = np.array([4000.0, -2500, 90, 0, 0, 0, 0])
    moved = Demonstration(d.t, d.hand + far, d.objects + far, d.object_names, d.object_sizes)
    assert np.allclose(read_demonstration(written(moved)).hand, d.hand + far)


def test_a_single_pose_astray_is_no_other_unit(written):
    hand = scaled().hand.copy()
    hand[100, 0] = 700
    d = scaled()
    read_demonstration(written(Demonstration(d.t, hand, d.objects, d.object_names, d.object_sizes)))


def test_an_opening_in_millimetres(written):
    d = scaled()
    opening = np.full(len(d.t), 80.0)
    path = written(Demonstration(d.t, d.hand, d.objects, d.object_names, d.object_sizes, opening))
    with pytest.raises(
        FileError, match=r"opens the hand by 80, which cannot be metres\. Give metres between"
    ):
        read_demonstration(path)
