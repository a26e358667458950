"""What a session starts from: a demonstration, or a recording that is observed first."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.frames import MUCH_LEFT_OUT
from imitate.formats.kind import kind_of, refuse_cloud
from imitate.formats.mapping import Mapping
from imitate.formats.recordings import open_recording
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
        notes: what the person ought to know of how it was read, in words.
        left_out: share of a recording's frames that are not among those observed.
    """

    name: str
    hash: str
    demonstration: Demonstration
    lost: dict[str, int] = field(default_factory=dict)
    symmetric: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    left_out: float = 0.0

    @property
    def much_lost(self) -> bool:
        """Whether so much of a recording is gone that what is made of it is not what was filmed."""
        return self.left_out > MUCH_LEFT_OUT


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
    name = os.fsencode(path.name).decode(errors="replace")  # a name need not be text, and a log holds text
    digest, notes = _hash(path), list[str]()
    if kind == "demonstration":
        demonstration = read_demonstration(path, mapping, notes)
        return Source(name, digest, demonstration, notes=tuple(notes))
    from imitate.perception.observe import observe  # Open3D takes seconds, and trajectories need none of it

    recording = open_recording(path, settings.perception)
    seen = observe(recording, settings, seed, watching)
    lost = seen.lost_frames
    notes += [*recording.notes, *seen.first.doubts]
    notes += [f"{name}: out of sight in {frames} frames; missing there" for name, frames in lost.items()]
    shown = seen.demonstration
    return Source(name, digest, shown, lost, shown.object_names, tuple(notes), recording.left_out)


def _hash(path: Path) -> str:
    digest = hashlib.sha256()
    for part in sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]:
        with part.open("rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()
