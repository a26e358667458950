"""What a file is: a demonstration, an RGB-D recording, a session or a single cloud, by its content."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from imitate.errors import FileError
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import FROM_ROS1

Kind = Literal["demonstration", "recording", "session", "cloud"]
TableFormat = Literal["npz", "csv", "parquet", "hdf5", "lerobot"]
POSE_SCHEMAS = (
    "foxglove.PoseInFrame",
    "foxglove.FrameTransform",
    "foxglove.FrameTransforms",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "geometry_msgs/msg/TransformStamped",
    "tf2_msgs/msg/TFMessage",
)
_FRAMES = {"foxglove.FrameTransform", "foxglove.FrameTransforms", "tf2_msgs/msg/TFMessage"}
"""those of them that a camera's recording has too."""
LEROBOT = Path("meta", "info.json")
"""what a folder in LeRobot's layout has."""
METADATA = "imitate"
"""the metadata record that says what one of our own MCAP files is, under the key "kind"."""
PICTURES = frozenset(
    {
        "foxglove.RawImage",
        "foxglove.CompressedImage",
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
    }
)
_ROS1 = re.compile(r"\w+_msgs/\w+")
"""a schema of ROS 1; in ROS 2 it is geometry_msgs/msg/PoseStamped."""
CLOUDS = frozenset({"foxglove.PointCloud", "sensor_msgs/msg/PointCloud2"})


def kind_of(path: Path | str) -> Kind:
    """Whether a file or folder holds a demonstration, an RGB-D recording, a session or a single cloud.

    Raises:
        FileError: no such file, or none of the four; the message says what it holds.
    """
    path = Path(path)
    if path.is_dir():
        return _kind_of_folder(path)
    if not path.exists():
        raise FileError(path, "no such file", "Give a recording, a demonstration or a session.")
    if table_format(path):
        return "demonstration"
    if _is_cloud(path):
        return "cloud"
    inside = contents(path)
    kind = inside.metadata.get(METADATA, {}).get("kind")
    if kind == "session":
        return "session"
    schemas = {schema for schema, _ in inside.topics.values()}
    if kind == "recording" or (kind is None and schemas & PICTURES):
        return "recording"
    if kind is None and schemas & CLOUDS and not schemas & set(POSE_SCHEMAS) - _FRAMES:
        return "recording"
    if kind == "demonstration" or schemas & set(POSE_SCHEMAS):
        return "demonstration"
    damage = f"; it is {inside.damage[0]}" if inside.damage else ""
    expected = f"A recording has colour and depth images, a demonstration {POSE_SCHEMAS[0]} topics."
    raise FileError(
        path,
        f"holds no recording, demonstration or session: {listed(inside.topics)}{damage}",
        FROM_ROS1 if any(map(_ROS1.fullmatch, schemas)) else expected,
    )


def table_format(path: Path) -> TableFormat | None:
    """Which format of arrays or columns a file or a folder has, by its content and for text by its suffix."""
    if path.is_dir():
        return "lerobot" if (path / LEROBOT).is_file() else None
    if path.suffix.lower() in (".npz", ".npy") or zipfile.is_zipfile(path):
        return "npz"
    with path.open("rb") as stream:
        start = stream.read(8)
    if start.startswith(b"PAR1"):
        return "parquet"
    if start == b"\x89HDF\r\n\x1a\n":
        return "hdf5"
    return "csv" if path.suffix.lower() in (".csv", ".tsv") else None


def refuse_cloud(path: Path, kind: Kind) -> None:
    """Raises FileError where something that moves is needed and a single cloud is given."""
    if kind == "cloud":
        raise FileError(
            path,
            "is a single cloud, which shows no movement",
            f"To see what is in it: imitate observe {path}",
        )


def _kind_of_folder(path: Path) -> Kind:
    if table_format(path):
        return "demonstration"
    lacking = [name for name in ("rgb.txt", "depth.txt") if not (path / name).is_file()]
    if not lacking:
        return "recording"
    inside = sorted(path.glob("*.mcap"))
    if inside:
        names = ", ".join(file.name for file in inside[:4])
        raise FileError(path, f"is a folder with {names}", f"Name the file inside it: {inside[0]}")
    problem = f"is a folder without {' and '.join(lacking)}"
    remedy = (
        "A recording in the layout of the TUM RGB-D benchmark has both; demonstrations in LeRobot's layout "
        f"have {LEROBOT}."
    )
    raise FileError(path, problem, remedy)


def _is_cloud(path: Path) -> bool:
    """PLY by its first word; PCD, which has no such word, by what its header starts with or by its name."""
    try:
        with path.open("rb") as stream:
            start = stream.read(64)
    except OSError:
        return False
    lines = start.split(b"\n")
    words = [line.split()[0] for line in lines if line.split() and not line.startswith(b"#")]
    if lines[0].strip() == b"ply" or (lines[0].startswith(b"#") and b".PCD" in lines[0]):
        return True
    return words[:1] in ([b"VERSION"], [b"FIELDS"]) or (
        bool(start) and path.suffix.lower() in (".pcd", ".ply")
    )


def listed(topics: Mapping[str, tuple[str, int]]) -> str:
    """Topics and their schemas in words, at most eight of them."""
    names = [f"{topic} ({schema or 'no schema'})" for topic, (schema, _) in topics.items()]
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return ("it has " + ", ".join(names[:8]) + more) if names else "it has no messages"
