"""`imitate observe` on single clouds and on recordings: JSON, labels, previews, and what is refused."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from imitate import cli
from imitate.geometry import compose

TABLETOP = Path(__file__).parents[3] / "shared" / "data" / "tabletop"
RNG = np.random.default_rng(4)


def scene():
    """(H·W, 3) a table seen from above at 45°, with one box of 20 × 12 × 10 cm on it, and (H, W)."""
    height, width, focal = 240, 320, 260.0
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([(u - 159.5) / focal, (v - 119.5) / focal, np.ones_like(u, float)], axis=-1)
    tilt = np.deg2rad(45)
    turn = np.array([[1, 0, 0], [0, -np.sin(tilt), -np.cos(tilt)], [0, np.cos(tilt), -np.sin(tilt)]])
    away = rays @ turn  # in a frame with z up, x right, y ahead
    origin = np.array([0, 0, 0.8])
    with np.errstate(divide="ignore", invalid="ignore"):
        table = np.where(away[..., 2] < 0, -origin[2] / away[..., 2], np.inf)
        at = origin + table[..., None] * away
        table = np.where((np.abs(at[..., 0]) < 0.6) & (at[..., 1] > 0.2) & (at[..., 1] < 1.4), table, np.nan)
        low, high = np.array([-0.1, 0.75, 0]), np.array([0.1, 0.87, 0.1])
        one, other = (low - origin) / away, (high - origin) / away
    enter, leave = np.minimum(one, other).max(axis=-1), np.maximum(one, other).min(axis=-1)
    depth = np.where(enter < leave, enter, table)
    depth = depth + RNG.normal(0, 0.0008, depth.shape)
    return (rays * depth[..., None]).reshape(-1, 3), (height, width)


def write_ply(path, points):
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(header.encode() + points.astype("<f4").tobytes())
    return path


def write_pcd(path, points, shape):
    header = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    header += f"WIDTH {shape[1]}\nHEIGHT {shape[0]}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\n"
    path.write_bytes(header.encode() + b"DATA binary\n" + points.astype("<f4").tobytes())
    return path


@pytest.fixture(scope="module")
def cloud(tmp_path_factory):
    points, shape = scene()
    return write_pcd(tmp_path_factory.mktemp("clouds") / "box.pcd", points, shape)


@pytest.fixture
def run(capsys):
    def run(*words):
        with pytest.raises(SystemExit) as end:
            cli.main(["observe", *map(str, words)])
        captured = capsys.readouterr()
        assert "unexpected" not in captured.err
        return end.value.code, captured.out, captured.err

    return run


def test_a_cloud_as_json_with_labels_and_a_preview(run, cloud, tmp_path):
    labels, preview = tmp_path / "labels.npy", tmp_path / "view.png"
    code, out, _ = run(cloud, "--json", "--labels", labels, "--preview", preview)
    assert code == 0
    found = json.loads(out)
    a, b, c, d = found["table"]["plane"]
    np.testing.assert_allclose([a, b, c, d], [0, -np.sqrt(0.5), -np.sqrt(0.5), 0.8], atol=0.005)
    (thing,) = found["objects"]
    assert {"name", "points", "size", "size_std", "pose", "uncertain"} <= set(thing)
    np.testing.assert_allclose(sorted(thing["size"]), [0.1, 0.12, 0.2], atol=0.01)
    away = compose(found["table"]["table_from_camera"], thing["pose"])
    np.testing.assert_allclose(away, thing["pose_in_table"], atol=1e-9)
    assert thing["pose_in_table"][2] == pytest.approx(thing["size"][2] / 2, abs=1e-6)
    middle = np.array(thing["pose"][:3])
    assert middle @ [a, b, c] + d == pytest.approx(thing["size"][2] / 2, abs=1e-6)
    own = np.load(labels)
    assert own.shape == (240 * 320,) and own.dtype.kind == "i"
    assert (own == 1).sum() == thing["points"] and (own == 0).sum() > 10000
    points, _ = scene()
    assert (own[np.isnan(points[:, 0])] == -1).all()
    np.testing.assert_allclose(np.nanmean(points[own == 1], axis=0), middle, atol=0.06)
    assert cv2.imread(str(preview)).shape == (480, 640, 3)


def test_a_cloud_in_words(run, cloud):
    code, out, _ = run(cloud)
    assert code == 0
    assert out.startswith("table: ") and "object" in out


def test_the_order_of_the_points_changes_nothing_but_the_labels(run, tmp_path):
    points, _ = scene()
    shuffled = RNG.permutation(len(points))
    file = write_ply(tmp_path / "box.ply", points[shuffled])
    code, out, _ = run(file, "--json", "--labels", tmp_path / "l.npy")
    assert code == 0
    (thing,) = json.loads(out)["objects"]
    np.testing.assert_allclose(sorted(thing["size"]), [0.1, 0.12, 0.2], atol=0.012)
    own = np.load(tmp_path / "l.npy")
    np.testing.assert_allclose(points[shuffled][own == 1].mean(axis=0), thing["pose"][:3], atol=0.06)
    code, _, err = run(file, "--preview", tmp_path / "l.png")
    assert code == 1
    assert "has its points in no picture's order" in err
    assert not (tmp_path / "l.png").exists()


def test_a_cloud_in_millimetres(run, tmp_path):
    points, shape = scene()
    file = write_pcd(tmp_path / "mm.pcd", 1000 * points, shape)
    code, out, err = run(file)
    assert (code, out) == (1, "")
    assert "holds depths in an unknown unit: at 1 m a step its middle reading is" in err
    assert "--depth-unit 0.001 for millimetres" in err
    code, out, _ = run(file, "--depth-unit", "0.001", "--json")
    assert code == 0
    assert len(json.loads(out)["objects"]) == 1


def test_a_cloud_without_a_table(run, tmp_path):
    points = RNG.uniform([-1, -1, 1.5], [1, 1, 3.5], (500, 3))
    code, _, err = run(write_ply(tmp_path / "dust.ply", points))
    assert code == 1
    assert f"{tmp_path / 'dust.ply'}: " in err and "table" in err
    assert "its 500 readings lie 1.6" in err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["-o", "d.npz"], "a single cloud shows no movement"),
        (["--preview", "v.gif"], "unknown suffix '.gif'. Use .png or .jpg or .mp4"),
        (["--preview", "v.mp4"], "is one moment, so that v.mp4 cannot be drawn"),
        (["--labels", "l.txt"], "unknown suffix '.txt'. Use .npy"),
        (["--intrinsics", "a,b"], "--intrinsics 'a,b': expected numbers with commas between them"),
        (["--intrinsics", "1,2,3"], "expected 4 or 8 or 9 numbers, got 3"),
    ],
)
def test_what_is_refused(run, cloud, words, expected, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(cloud, *words)
    assert code in (1, 2) and out == ""
    assert expected in err
    assert list(tmp_path.iterdir()) == []


def test_a_cloud_cannot_be_learned_from(capsys, cloud):
    with pytest.raises(SystemExit) as end:
        cli.main(["segment", str(cloud)])
    assert end.value.code == 1
    assert "is a single cloud, which shows no movement. To see what is in it: imitate observe" in (
        capsys.readouterr().err
    )


@pytest.mark.skipif(not TABLETOP.exists(), reason="the shared Kinect scenes are not here")
def test_a_stack_of_boxes_is_uncertain_in_words(run):
    code, out, err = run(TABLETOP / "mosd_learn17.pcd", "--json")
    assert code == 0
    assert any(thing["uncertain"] and thing["reason"] for thing in json.loads(out)["objects"])
    assert "uncertain, it may be more than one thing or no block" in err


def test_a_cloud_whose_z_points_at_the_sensor(run, tmp_path):
    points, shape = scene()
    turned = write_pcd(tmp_path / "turned.pcd", points * [1, -1, -1], shape)
    code, out, err = run(turned, "--json")
    assert code == 0 and "z towards the sensor; --sensor says otherwise" in err
    found = json.loads(out)
    assert found["cloud_from_camera"] == pytest.approx([0, 0, 0, 1, 0, 0, 0])
    assert len(found["objects"]) == 1 and found["table"]["doubt"] == ""
    code, _, err = run(turned, "--sensor", "optical")
    assert code == 1 and "no point lies before the camera" in err and "--sensor" in err
    code, _, err = run(turned, "--sensor", "up")
    assert code == 2 and "expected optical, graphics, body, viewpoint, or seven numbers" in err


def test_a_table_that_carries_nothing_is_doubted(run, tmp_path):
    points, shape = scene()
    points[np.abs(points[:, 0]) < 0.2] = np.nan
    code, out, err = run(write_pcd(tmp_path / "bare.pcd", points, shape))
    assert code == 0 and "nothing stands on it" in out
    assert "table: doubtful, it may be another plane: nothing stands on it" in err
