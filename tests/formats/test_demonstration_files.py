from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from imitate.demonstration import Demonstration
from imitate.errors import DemonstrationError, FileError, ImitateError
from imitate.formats.demonstrations import SUFFIXES, read_demonstration, write_demonstration
from imitate.formats.kind import kind_of
from imitate.geometry import normalised

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "demonstrations"


def demonstration(
    frames: int = 6, names: tuple[str, ...] = ("blue", "green"), seed: int = 0
) -> Demonstration:
    rng = np.random.default_rng(seed)
    sizes = rng.uniform(0.02, 0.1, (len(names), 3))
    sizes[-1] = np.nan
    return Demonstration(
        t=np.cumsum(rng.uniform(0.01, 0.03, frames)),
        hand=normalised(rng.normal(size=(frames, 7))),
        objects=normalised(rng.normal(size=(frames, len(names), 7))),
        object_names=names,
        object_sizes=sizes,
    )


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def with_gaps(written: Demonstration, share: float = 0.4, seed: int = 1) -> Demonstration:
    """Poses that were not seen, but for two of each body."""
    rng = np.random.default_rng(seed)
    hand, objects = np.array(written.hand), np.array(written.objects)
    for poses in (hand, *np.moveaxis(objects, 1, 0)):
        unseen = rng.uniform(size=len(poses)) < share
        unseen[rng.choice(len(poses), 2, replace=False)] = False
        poses[unseen] = np.nan
    return replace(written, hand=hand, objects=objects)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("seen", [1.0, 0.6, 0.0])
def test_the_opening_is_read_as_it_was_written(tmp_path: Path, suffix: str, seen: float) -> None:
    rng = np.random.default_rng(3)
    opening = np.where(rng.uniform(size=6) < seen, rng.uniform(0, 0.1, 6), np.nan)
    written = replace(with_gaps(demonstration()), opening=opening)
    write_demonstration(written, tmp_path / f"demo{suffix}")
    read = read_demonstration(tmp_path / f"demo{suffix}")
    assert read.opening is not None
    assert same_bits(read.opening, written.opening)
    assert same_bits(read.hand, written.hand)
    assert kind_of(tmp_path / f"demo{suffix}") == "demonstration"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_is_written_is_read(tmp_path: Path, suffix: str) -> None:
    written = demonstration()
    write_demonstration(written, tmp_path / f"demo{suffix}")
    read = read_demonstration(tmp_path / f"demo{suffix}")
    assert kind_of(tmp_path / f"demo{suffix}") == "demonstration"
    assert read.object_names == written.object_names
    for field in ("hand", "objects"):
        assert same_bits(getattr(read, field), getattr(written, field)), field
    assert read.opening is None
    np.testing.assert_array_equal(read.object_sizes, written.object_sizes)
    np.testing.assert_allclose(read.t, written.t, atol=0.5e-9 if suffix == ".mcap" else 0)


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    frames=st.integers(2, 20),
    names=st.lists(st.text("abc xyzäπ_-", min_size=1, max_size=8), min_size=1, max_size=4, unique=True),
    seed=st.integers(0, 2**16),
    share=st.sampled_from([0.0, 0.3, 0.9]),
)
def test_any_demonstration_survives_or_is_refused(
    tmp_path: Path, suffix: str, frames: int, names: list[str], seed: int, share: float
) -> None:
    written = with_gaps(demonstration(frames, tuple(names), seed), share, seed)
    path = tmp_path / f"demo{suffix}"
    try:
        write_demonstration(written, path, force=True)
    except FileError as error:
        assert suffix in (".csv", ".parquet")
        assert "would not be recognised" in str(error)
        return
    read = read_demonstration(path)
    assert read.object_names == written.object_names
    np.testing.assert_array_equal(read.hand, written.hand)
    np.testing.assert_array_equal(read.objects, written.objects)
    np.testing.assert_allclose(read.t, written.t, atol=0.5e-9)


def test_times_in_nanoseconds_survive_exactly(tmp_path: Path) -> None:
    t = np.array([1_700_000_000_123_456_789 + k * 33_333_333 for k in range(4)]) / 10**9
    written = demonstration(4)
    written = Demonstration(t, written.hand, written.objects, written.object_names, written.object_sizes)
    write_demonstration(written, tmp_path / "demo.mcap")
    assert same_bits(read_demonstration(tmp_path / "demo.mcap").t, t)


def test_nothing_is_overwritten_unasked(tmp_path: Path) -> None:
    path = tmp_path / "demo.npz"
    path.write_bytes(b"mine")
    with pytest.raises(FileError, match=r"demo.npz: exists already\. .*--force"):
        write_demonstration(demonstration(), path)
    assert path.read_bytes() == b"mine"
    write_demonstration(demonstration(), path, force=True)
    assert read_demonstration(path).object_names == ("blue", "green")
    assert [entry.name for entry in tmp_path.iterdir()] == ["demo.npz"]


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def disk_full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", disk_full)
    with pytest.raises(FileError, match=r"cannot be written .No space left on device"):
        write_demonstration(demonstration(), tmp_path / "demo.npz")
    assert list(tmp_path.iterdir()) == []


def test_a_name_with_a_slash_is_not_a_topics_last_part(tmp_path: Path) -> None:
    slashed = demonstration(names=("blue", "a/b"))
    with pytest.raises(FileError, match=r"cannot hold a/b.*Write .npz"):
        write_demonstration(slashed, tmp_path / "demo.mcap")
    assert list(tmp_path.iterdir()) == []
    write_demonstration(slashed, tmp_path / "demo.npz")
    assert read_demonstration(tmp_path / "demo.npz").object_names == ("blue", "a/b")


def test_sizes_may_be_left_out(tmp_path: Path) -> None:
    d = demonstration()
    np.savez(tmp_path / "d.npz", t=d.t, hand=d.hand, objects=d.objects, object_names=np.array(d.object_names))
    assert np.isnan(read_demonstration(tmp_path / "d.npz").object_sizes).all()


def saved(path: Path, **changes: object) -> Path:
    d = demonstration()
    fields: dict[str, object] = {
        "t": d.t,
        "hand": d.hand,
        "objects": d.objects,
        "object_names": np.array(d.object_names),
    }
    fields.update(changes)
    np.savez(path, allow_pickle=True, **{name: value for name, value in fields.items() if value is not None})
    return path


def nan_hand() -> np.ndarray:
    hand = np.array(demonstration().hand)
    hand[2, 1] = np.nan
    return hand


@pytest.mark.parametrize(
    ("changes", "kind", "message"),
    [
        ({"hand": None}, FileError, r"d.npz: has no array 'hand'; it has t \(6,\), .*object_names \(K,\)"),
        ({"hand": None, "t": None}, FileError, r"has no array 't' and no 'hand'"),
        ({"hand": nan_hand()}, DemonstrationError, r"d.npz: hand: NaN or infinite at frame 2, 1 frames"),
        ({"hand": demonstration().hand * 2}, DemonstrationError, r"d.npz: hand: quaternion of length 2 at"),
        ({"t": demonstration().t[::-1]}, DemonstrationError, r"d.npz: t: goes from .* at frame 1"),
        ({"t": np.array(["a"] * 6)}, FileError, r"d.npz: t holds <U1, not numbers"),
        ({"t": np.array([{}] * 6)}, FileError, r"d.npz: is not an NPZ archive of plain arrays"),
        ({"objects": demonstration().objects[:, :1]}, DemonstrationError, r"objects: shape \(6, 1, 7\)"),
    ],
)
def test_each_fault_has_its_message(
    tmp_path: Path, changes: dict[str, object], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        read_demonstration(saved(tmp_path / "bad.npz", **changes))


def test_missing_file_and_wrong_content(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none.npz: no such file"):
        read_demonstration(tmp_path / "none.npz")
    (tmp_path / "text.mcap").write_text("hello there")
    with pytest.raises(FileError, match=r"text.mcap: is not an MCAP file: it starts with b'hello th'"):
        read_demonstration(tmp_path / "text.mcap")
    (tmp_path / "text.npz").write_text("hello there")
    with pytest.raises(FileError, match=r"text.npz: is not an NPZ archive: it starts with"):
        read_demonstration(tmp_path / "text.npz")
    (tmp_path / "cut.npz").write_bytes(saved(tmp_path / "whole.npz").read_bytes()[:500])
    with pytest.raises(FileError, match=r"cut.npz: is not an NPZ archive"):
        read_demonstration(tmp_path / "cut.npz")
    with pytest.raises(FileError, match=r"unknown suffix '.xls'. Use .npz, .csv, .parquet or .mcap"):
        write_demonstration(demonstration(), tmp_path / "demo.xls")


def test_content_counts_more_than_the_suffix(tmp_path: Path) -> None:
    write_demonstration(demonstration(), tmp_path / "demo.npz")
    renamed = (tmp_path / "demo.npz").rename(tmp_path / "demo.mcap")
    assert kind_of(renamed) == "demonstration"
    assert read_demonstration(renamed).object_names == ("blue", "green")


@pytest.mark.skipif(not SHARED.is_dir(), reason="shared data is not beside the project")
def test_every_shared_demonstration_is_read() -> None:
    for path in sorted(SHARED.glob("*.npz")):
        assert read_demonstration(path).duration > 0.9


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".parquet", ".mcap"])
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_damage_is_always_explained(tmp_path: Path, suffix: str, data: st.DataObject) -> None:
    whole = tmp_path / f"whole{suffix}"
    if not whole.exists():
        write_demonstration(demonstration(), whole)
    changed = bytearray(whole.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        changed[data.draw(st.integers(0, len(changed) - 1))] = data.draw(st.integers(0, 255))
    changed = changed[: data.draw(st.integers(len(changed) // 2, len(changed)))]
    path = tmp_path / f"damaged{suffix}"
    path.write_bytes(changed)
    for read in (read_demonstration, kind_of):
        try:
            read(path)
        except ImitateError as error:
            assert str(error).startswith(str(path))
