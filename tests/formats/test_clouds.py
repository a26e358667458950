"""Single clouds: every encoding of PCD and PLY gives the same points, in the order of the file."""

import struct
from pathlib import Path

import lzf
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.errors import FileError
from imitate.formats.clouds import read_cloud, unpacked_colour

TABLETOP = Path(__file__).parents[3] / "shared" / "data" / "tabletop"
POINTS = np.array([[0.1, -0.2, 0.9], [np.nan] * 3, [0.3, 0, 1.1], [0, 0.5, 1]], np.float32)
COLOUR = np.array([[255, 0, 10], [1, 2, 3], [0, 255, 128], [7, 8, 9]], np.uint8)
PACKED = (COLOUR.astype(np.uint32) << [16, 8, 0]).sum(axis=1).astype(np.uint32)


def pcd(data, rgb="U", height=2, points=4, fields="x y z label rgba"):
    return (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE 4 4 4 2 4\nTYPE F F F U {rgb}\nCOUNT 1 1 1 2 1\n"
        f"WIDTH {points // height}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    ).encode()


def rows(order="<"):
    kinds = [(n, f"{order}f4") for n in "xyz"] + [("label", f"{order}u2", 2), ("rgba", f"{order}u4")]
    table = np.zeros(4, kinds)
    for axis, values in zip("xyz", POINTS.T, strict=True):
        table[axis] = values
    table["rgba"] = PACKED
    return table


def ascii_rows(colour):
    lines = [f"{x} {y} {z}  5 6 {c} " for (x, y, z), c in zip(POINTS, colour, strict=True)]
    return "\n".join(lines).encode() + b"\n"


def compressed():
    plain = b"".join(rows()[name].tobytes() for name in rows().dtype.names) + bytes(0)
    packed = lzf.compress(plain, 4 * len(plain) + 64)
    return struct.pack("<II", len(packed), len(plain)) + packed


PLY = (
    "ply\nformat {form} 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float32 z\nproperty ushort a\nproperty uint16 b\nproperty uchar red\nproperty uchar green\n"
    "property uchar blue\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"
)


def ply(form):
    if form == "ascii":
        lines = [" ".join(map(str, [*p, 5, 6, *c])) for p, c in zip(POINTS, COLOUR, strict=True)]
        return PLY.format(form=form).encode() + "\n".join(lines).encode()
    order = "<" if "little" in form else ">"
    fields = [(n, f"{order}f4") for n in "xyz"] + [(f"label{n}", f"{order}u2") for n in "ab"]
    table = np.zeros(4, fields + [(n, "u1") for n in ("r", "g", "b")])
    for axis, values in zip("xyz", POINTS.T, strict=True):
        table[axis] = values
    for band, values in zip("rgb", COLOUR.T, strict=True):
        table[band] = values
    return PLY.format(form=form).encode() + table.tobytes()


@pytest.mark.parametrize(
    ("data", "shape"),
    [
        (pcd("ascii") + ascii_rows(PACKED), (2, 2)),
        (pcd("ascii", rgb="F") + ascii_rows(PACKED), (2, 2)),
        (pcd("ascii", rgb="F") + ascii_rows(PACKED.view(np.float32)), (2, 2)),
        (pcd("binary") + rows().tobytes(), (2, 2)),
        (pcd("binary", rgb="F", height=1) + rows().tobytes(), None),
        (pcd("binary_compressed") + compressed(), (2, 2)),
        (ply("ascii"), None),
        (ply("binary_little_endian"), None),
        (ply("binary_big_endian"), None),
    ],
    ids=[
        "ascii",
        "ascii-whole",
        "ascii-float",
        "binary",
        "unorganised",
        "compressed",
        "ply",
        "ply-little",
        "ply-big",
    ],
)
def test_the_same_points_from_every_encoding(tmp_path, data, shape):
    path = tmp_path / "cloud"
    path.write_bytes(data)
    cloud = read_cloud(path)
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-6)
    np.testing.assert_array_equal(cloud.colour, COLOUR)
    assert cloud.shape == shape


@given(st.lists(st.integers(0, 2**24 - 1), min_size=1, max_size=9), st.sampled_from([0, 0xFF000000]))
def test_a_packed_colour_is_the_same_as_integer_and_as_float(colours, alpha):
    packed = np.array(colours, np.uint32) | np.uint32(alpha)
    unpacked = unpacked_colour(packed)
    assert [int(r) << 16 | int(g) << 8 | int(b) for r, g, b in unpacked] == colours
    # a NaN with other bits than the usual ones is what a bright opaque colour looks like as a float
    np.testing.assert_array_equal(unpacked_colour(packed.view(np.float32)), unpacked)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is empty"),
        (b"Dear diary", "is no point cloud: it starts with b'Dear dia'"),
        (pcd("binary") + rows().tobytes()[:50], "is cut: it holds 2 of 4 points"),
        (pcd("ascii") + b"1 2 3 4 5 6 1 2", "is cut: it holds 1 of 4 points"),
        (pcd("binary_compressed") + compressed()[:-3], "is cut or damaged"),
        (pcd("lzma"), "holds PCD data of the kind 'lzma'"),
        (
            pcd("binary", fields="x y depth label rgba") + rows().tobytes(),
            "has no field z; it has x, y",
        ),
        (b"VERSION 0.7\nFIELDS x\nDATA ascii\n", "has a PCD header that cannot be understood"),
        (ply("ascii")[:60], "is cut inside its header"),
        (b"ply\nformat ascii 1.0\nelement face 1\nend_header\n", "starts with face, not with its vertices"),
        (pcd("ascii") + b"nan nan nan 0 0 0\n" * 4, "holds 4 points, none of which was read"),
    ],
)
def test_what_is_wrong_with_a_cloud(tmp_path, data, words):
    path = tmp_path / "bad.pcd"
    path.write_bytes(data)
    with pytest.raises(FileError, match=rf"bad.pcd: {words}"):
        read_cloud(path)


def test_a_missing_cloud_and_a_folder(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_cloud(tmp_path / "none.pcd")
    with pytest.raises(FileError, match="is a folder"):
        read_cloud(tmp_path)


@pytest.mark.skipif(not TABLETOP.exists(), reason="the shared Kinect scenes are not here")
def test_a_real_scene_is_what_open3d_reads():
    import open3d as o3d

    path = TABLETOP / "mosd_learn0.pcd"
    cloud, other = read_cloud(path), o3d.io.read_point_cloud(str(path), remove_nan_points=False)
    assert cloud.shape == (480, 640)
    np.testing.assert_array_equal(cloud.points, np.asarray(other.points))
    np.testing.assert_allclose(cloud.colour / 255, np.asarray(other.colors), atol=0.003)
