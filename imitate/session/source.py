"""What a session starts from: a demonstration, or a recording that is observed first."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.kind import kind_of, refuse_cloud
from imitate.formats.mapping import Mapping
from imitate.settings import Settings

Watching = Callable[[int, int], None]


@dataclass(frozen=True)
class Source:
    """A demonstration and where it came from.

    Attributes:
        name: of the file.
        hash: SHA-256 of the file, hexadecimal.
        demonstration: as read or as observed.
        lost: hand or object → frames in which it was not seen.
        symmetric: objects that the tracker cannot tell from themselves turned: it sees each in one colour.
    """

    name: str
    hash: str
    demonstration: Demonstration
    lost: dict[str, int] = field(default_factory=dict)
    symmetric: tuple[str, ...] = ()


def read_source(
    path: Path,
    settings: Settings,
    seed: int,
    watching: Watching | None = None,
    mapping: Mapping | None = None,
) -> Source:
    """Reads a demonstration, or observes a recording; ``watching`` hears of frames done and frames in all.

    With a ``mapping`` the file is a demonstration, whatever else it holds.

    Raises:
        FileError: neither of the two, or damaged.
    """
    kind = "demonstration" if mapping else kind_of(path)
    if kind == "session":
        raise FileError(
            path, "is a session", f"Give the demonstration it was learned from, or: imitate replay {path}"
        )
    refuse_cloud(path, kind)
    digest = _hash(path)
    if kind == "demonstration":
        return Source(path.name, digest, read_demonstration(path, mapping))
    from imitate.perception.observe import observe  # Open3D takes seconds, and trajectories need none of it

    seen = observe(path, settings, seed, watching)
    return Source(path.name, digest, seen.demonstration, seen.lost_frames, seen.demonstration.object_names)


def _hash(path: Path) -> str:
    digest = hashlib.sha256()
    for part in sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]:
        with part.open("rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()
