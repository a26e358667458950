"""Single point clouds: PCD (ascii, binary, binary_compressed) and PLY, in the order of the file.

PCD: pointclouds.org, "The PCD file format" 0.7. PLY: G. Turk, "The PLY polygon file format", 1994.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import lzf
import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.distances import check_distances
from imitate.formats.organised import fitted_intrinsics
from imitate.formats.sensor_frame import SENSORS, named_frame
from imitate.geometry import IDENTITY, Array
from imitate.rgbd import PointCloud

_HEADER = 64 * 1024
"""bytes within which a header has to end."""
_REMEDY = "Give a PCD or PLY file with the fields x, y and z in metres."
_PCD = {("F", 4): "f4", ("F", 8): "f8"} | {
    (kind, size): f"{kind.lower()}{size}" for kind in "UI" for size in (1, 2, 4, 8)
}
_PLY = {
    name: code
    for code, names in {
        "i1": "char int8",
        "u1": "uchar uint8",
        "i2": "short int16",
        "u2": "ushort uint16",
        "i4": "int int32",
        "u4": "uint uint32",
        "f4": "float float32",
        "f8": "double float64",
    }.items()
    for name in names.split()
}


def read_cloud(path: Path | str, unit: float = 0.0, sensor: str = "") -> PointCloud:
    """A cloud from a PCD or PLY file, told apart by its content; points that were not read stay NaN.

    Args:
        path: the file.
        unit: metres of 1.0 in it; 0: it should be in metres, which is checked.
        sensor: the frame in which it is given, as of `named_frame`; "": found, and noted where it is not the
            camera's.

    Raises:
        FileError: no such file, neither of the two, cut, without x, y, z, without the viewpoint that is asked
            for, or plainly not in metres.
    """
    path = Path(path)
    cloud, viewpoint = _read(path)
    points = cloud.points * (unit or 1.0)
    if viewpoint is not None:
        viewpoint = np.concatenate([viewpoint[:3] * (unit or 1.0), viewpoint[3:]])
    elif sensor == "viewpoint":
        raise FileError(path, "says nothing of a viewpoint", f"Expected {SENSORS}: --sensor.")
    frame = named_frame(sensor, viewpoint, points, cloud.shape)
    if frame is None:
        return replace(cloud, points=points)
    points = frame.seen(points)
    if not unit:
        away = np.linalg.norm(points[~np.isnan(points[:, 0])], axis=1)
        check_distances(path, "the cloud", away, 1.0)
    notes = [f"its frame is taken as that {frame.words}; --sensor says otherwise"] if frame.words else []
    if cloud.shape and fitted_intrinsics(points.reshape(*cloud.shape, 3)) is None:
        notes.append("no camera there sees each point in its own pixel; --sensor says where it is")
    return replace(cloud, points=points, cloud_from_camera=frame.pose, notes=tuple(notes))


def _read(path: Path) -> tuple[PointCloud, Array | None]:
    """The cloud as it is given, and the sensor's pose (7,) in a world where the file says one."""
    if path.is_dir():
        raise FileError(path, "is a folder", _REMEDY)
    try:
        with path.open("rb") as stream:
            start = stream.read(_HEADER)
            stream.seek(0)
            if start.split(b"\n", 1)[0].strip() == b"ply":
                return _read_ply(path, stream), None
            if b"\nDATA" in start or start.startswith(b"DATA"):
                return _read_pcd(path, stream)
    except FileNotFoundError:
        raise FileError(path, "no such file") from None
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error})") from None
    if not start:
        raise FileError(path, "is empty", _REMEDY)
    raise FileError(path, f"is no point cloud: it starts with {start[:8]!r}", _REMEDY)


@dataclass(frozen=True)
class _PcdHeader:
    fields: list[tuple[str, str, int]]  # name, dtype, count
    points: int
    shape: tuple[int, int]
    data: str
    viewpoint: Array | None

    @property
    def dtype(self) -> np.dtype[Any]:
        rows = [(f"{k}:{name}", kind, (count,)) for k, (name, kind, count) in enumerate(self.fields)]
        return np.dtype(rows).newbyteorder("<")


def _read_pcd(path: Path, stream: IO[bytes]) -> tuple[PointCloud, Array | None]:
    header = _pcd_header(path, stream)
    if header.data == "ascii":
        columns = _ascii_columns(path, stream, header.fields, header.points)
    elif header.data == "binary":
        columns = _binary_columns(path, stream, header.dtype, header.fields, header.points)
    else:
        columns = _compressed_columns(path, stream, header)
    height, width = header.shape
    organised = height > 1 and height * width == header.points
    return _cloud(path, columns, (height, width) if organised else None), header.viewpoint


def _pcd_header(path: Path, stream: IO[bytes]) -> _PcdHeader:
    words: dict[str, list[str]] = {}
    while "DATA" not in words:
        line = stream.readline(_HEADER)
        if not line:
            raise FileError(path, "is cut inside its header", "Copy or export it again.")
        key, _, rest = line.decode("latin1").partition("#")[0].strip().partition(" ")
        words[key.upper()] = rest.split()
    try:
        names = words.get("FIELDS") or words["COLUMNS"]
        counts = [int(n) for n in words.get("COUNT", ["1"] * len(names))]
        kinds = [_PCD[t.upper(), int(s)] for t, s in zip(words["TYPE"], words["SIZE"], strict=True)]
        width, height = int(words["WIDTH"][0]), int(words.get("HEIGHT", ["1"])[0])
        points = int(words.get("POINTS", [str(width * height)])[0])
        data = words["DATA"][0].lower()
        fields = list(zip(names, kinds, counts, strict=True))
        viewpoint = _viewpoint([float(word) for word in words.get("VIEWPOINT", [])])
    except (KeyError, ValueError, IndexError) as error:
        raise FileError(path, f"has a PCD header that cannot be understood ({error})", _REMEDY) from None
    if data not in ("ascii", "binary", "binary_compressed"):
        raise FileError(
            path, f"holds PCD data of the kind {data!r}", "Expected ascii, binary or binary_compressed."
        )
    return _PcdHeader(fields, points, (height, width), data, viewpoint)


def _viewpoint(numbers: list[float]) -> Array | None:
    """The sensor's pose (7,) from x y z qw qx qy qz; None where that is the origin, as by default."""
    if len(numbers) != 7 or not (length := np.linalg.norm(numbers[3:])) or not np.isfinite(length):
        return None
    pose = np.array([*numbers[:3], *numbers[4:], numbers[3]])
    pose[3:] /= length
    return None if np.allclose(pose, IDENTITY) else pose


def _ascii_columns(
    path: Path, stream: IO[bytes], fields: list[tuple[str, str, int]], points: int
) -> dict[str, NDArray[Any]]:
    """Each field's first value, as float64, which holds every 32-bit number exactly."""
    width = sum(count for _, _, count in fields)
    words = stream.read().split()
    if len(words) < width * points:
        raise _cut(path, len(words) // max(width, 1), points)
    try:
        rows = np.array(words[: width * points], dtype="S").astype(np.float64).reshape(points, width)
    except ValueError as error:
        raise FileError(path, f"holds a word that is no number ({error})", _REMEDY) from None
    starts = np.cumsum([0, *(count for _, _, count in fields)])
    columns = {}
    for (name, _, _), start in zip(fields, starts[:-1], strict=True):
        column = rows[:, start]
        if name in ("rgb", "rgba"):
            # a packed colour is printed as the whole number it is, or as the float that it pretends to be
            whole = bool(np.all((column == 0) | (column >= 1)))
            column = column.astype("u4" if whole else "f4")
        columns[name] = column
    return columns


def _binary_columns(
    path: Path, stream: IO[bytes], dtype: np.dtype[Any], fields: list[tuple[str, str, int]], points: int
) -> dict[str, NDArray[Any]]:
    data = stream.read(points * dtype.itemsize)
    if len(data) < points * dtype.itemsize:
        raise _cut(path, len(data) // dtype.itemsize, points)
    rows = np.frombuffer(data, dtype)
    return {name: rows[f"{k}:{name}"][:, 0] for k, (name, _, _) in enumerate(fields)}


def _compressed_columns(path: Path, stream: IO[bytes], header: _PcdHeader) -> dict[str, NDArray[Any]]:
    """Field after field, LZF-compressed as a whole."""
    sizes = np.frombuffer(stream.read(8).ljust(8, b"\0"), "<u4")
    packed, size = int(sizes[0]), int(sizes[1])
    data = stream.read(packed)
    if len(data) < packed or size != header.points * header.dtype.itemsize:
        raise FileError(
            path, f"is cut or damaged: {len(data):,} of {packed:,} compressed bytes", "Copy it again."
        )
    plain = lzf.decompress(data, size) if size else b""
    if plain is None or len(plain) != size:
        raise FileError(path, "is damaged: its compressed points do not unpack", "Copy it again.")
    columns, start = {}, 0
    for name, kind, count in header.fields:
        held = np.frombuffer(plain, f"<{kind}", header.points * count, start)
        columns[name] = held.reshape(header.points, count)[:, 0]
        start += held.nbytes
    return columns


def _read_ply(path: Path, stream: IO[bytes]) -> PointCloud:
    form, elements = _ply_header(path, stream)
    if not elements or elements[0][0] != "vertex":
        first = elements[0][0] if elements else "nothing"
        raise FileError(path, f"starts with {first}, not with its vertices", _REMEDY)
    _, count, properties = elements[0]
    if any(kind is None for _, kind in properties):
        raise FileError(path, "has a list among the properties of its vertices", _REMEDY)
    fields = [(name, kind, 1) for name, kind in properties if kind is not None]
    if form == "ascii":
        return _cloud(path, _ascii_columns(path, stream, fields, count), None)
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(form)
    if order is None:
        raise FileError(path, f"holds PLY data of the kind {form!r}", _REMEDY)
    dtype = np.dtype([(f"{k}:{name}", order + kind, (1,)) for k, (name, kind, _) in enumerate(fields)])
    return _cloud(path, _binary_columns(path, stream, dtype, fields, count), None)


_Element = tuple[str, int, list[tuple[str, str | None]]]


def _ply_header(path: Path, stream: IO[bytes]) -> tuple[str, list[_Element]]:
    form = ""
    elements: list[_Element] = []
    while line := stream.readline(_HEADER):
        words = line.decode("latin1").split()
        try:
            match words:
                case ["end_header"]:
                    return form, elements
                case ["format", form, *_]:
                    pass
                case ["element", name, count]:
                    elements.append((name, int(count), []))
                case ["property", "list", _, _, name]:
                    elements[-1][2].append((name, None))
                case ["property", kind, name]:
                    elements[-1][2].append((name, _PLY[kind]))
        except (KeyError, ValueError, IndexError):
            problem = f"has a PLY header that cannot be understood: {line.decode('latin1').strip()!r}"
            raise FileError(path, problem, _REMEDY) from None
    raise FileError(path, "is cut inside its header", "Copy or export it again.")


def _cloud(path: Path, columns: dict[str, NDArray[Any]], shape: tuple[int, int] | None) -> PointCloud:
    missing = [axis for axis in "xyz" if axis not in columns]
    if missing:
        has = ", ".join(columns) or "none"
        raise FileError(path, f"has no field {' and no '.join(missing)}; it has {has}", _REMEDY)
    points = np.stack([columns[axis] for axis in "xyz"], axis=1).astype(np.float64)
    points[~np.isfinite(points).all(axis=1)] = np.nan
    if not len(points) or np.isnan(points).all():
        raise FileError(path, f"holds {len(points)} points, none of which was read", _REMEDY)
    return PointCloud(points, _colour(columns), shape)


def _colour(columns: dict[str, NDArray[Any]]) -> NDArray[np.uint8] | None:
    for packed in ("rgb", "rgba"):
        if packed in columns:
            return unpacked_colour(columns[packed])
    for names in (
        ("red", "green", "blue"),
        ("r", "g", "b"),
        ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ):
        if all(name in columns for name in names):
            bands = np.stack([columns[name] for name in names], axis=1)
            if bands.dtype.kind == "f" and np.nanmax(bands, initial=0) <= 1:
                bands = 255 * bands
            return np.asarray(np.nan_to_num(bands).clip(0, 255), np.uint8)
    return None


def unpacked_colour(packed: NDArray[Any]) -> NDArray[np.uint8]:
    """(…, 3) red green blue of 0xaarrggbb, in 32-bit integers or in floats of the same bits."""
    if packed.dtype.kind == "f":
        bits = np.ascontiguousarray(packed.astype(np.float32)).view(np.uint32)
    else:
        bits = packed.astype(np.uint32)
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=-1).astype(np.uint8)


def _cut(path: Path, found: int, points: int) -> FileError:
    return FileError(path, f"is cut: it holds {found:,} of {points:,} points", "Copy or export it again.")
