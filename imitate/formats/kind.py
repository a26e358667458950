"""What a file is: a demonstration, an RGB-D recording or a session, by its content."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from imitate.errors import FileError
from imitate.formats.mcap_file import contents

Kind = Literal["demonstration", "recording", "session"]
POSE_SCHEMA = "foxglove.PoseInFrame"
METADATA = "imitate"
"""the metadata record that says what one of our own MCAP files is, under the key "kind"."""
_PICTURES = {
    "foxglove.RawImage",
    "foxglove.CompressedImage",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
}


def kind_of(path: Path | str) -> Kind:
    """Whether a file or folder holds a demonstration, an RGB-D recording or a session.

    Raises:
        FileError: no such file, or none of the three; the message says what it holds.
    """
    path = Path(path)
    if path.is_dir():
        if (path / "rgb.txt").exists() and (path / "depth.txt").exists():
            return "recording"
        raise FileError(path, "is a folder without rgb.txt and depth.txt", "A recording's folder has both.")
    if not path.exists():
        raise FileError(path, "no such file", "Give a recording, a demonstration or a session.")
    if path.suffix == ".npz" or zipfile.is_zipfile(path):
        return "demonstration"
    inside = contents(path)
    kind = inside.metadata.get(METADATA, {}).get("kind")
    if kind == "session":
        return "session"
    schemas = {schema for schema, _ in inside.topics.values()}
    if kind == "recording" or (kind is None and schemas & _PICTURES):
        return "recording"
    if kind == "demonstration" or POSE_SCHEMA in schemas:
        return "demonstration"
    damage = f"; it is {inside.damage[0]}" if inside.damage else ""
    raise FileError(
        path,
        f"holds no recording, demonstration or session: {listed(inside.topics)}{damage}",
        f"A recording has colour and depth images, a demonstration {POSE_SCHEMA} topics.",
    )


def listed(topics: Mapping[str, tuple[str, int]]) -> str:
    """Topics and their schemas in words, at most eight of them."""
    names = [f"{topic} ({schema or 'no schema'})" for topic, (schema, _) in topics.items()]
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return ("it has " + ", ".join(names[:8]) + more) if names else "it has no messages"
