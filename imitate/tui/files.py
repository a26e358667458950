"""The operator's files: of which kind each is, and what it holds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.settings import Settings
from imitate.tui.words import demonstration_facts, demonstration_faults, session_facts

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from imitate.formats.kind import Kind
    from imitate.formats.mapping import Mapping

    Image = NDArray[np.uint8]


SURVEYED = 1 << 27
"""bytes up to which a recording's stamps are gone through before it is opened."""


@dataclass(frozen=True, eq=False)
class Preview:
    """What a file holds.

    Attributes:
        kind: of the file.
        facts: as (name, value).
        wrong: what the operator ought to know before opening it, in words.
        picture: (H, W, 3) red green blue, the first of a recording.
    """

    kind: Kind
    facts: tuple[tuple[str, str], ...]
    wrong: tuple[str, ...] = ()
    picture: Image | None = None


def kind_of(path: Path) -> Kind:
    """What kind of file it is."""
    from imitate.formats.kind import kind_of as kind
    from imitate.formats.kind import refuse_cloud

    found = kind(path)
    refuse_cloud(path, found)
    return found


def look(path: Path, mapping: Mapping | None = None) -> Preview:
    """What a file holds, in words; with a ``mapping`` it is a demonstration."""
    kind = "demonstration" if mapping else kind_of(path)
    if kind == "demonstration":
        notes: list[str] = []
        demonstration = read(path, notes, mapping)
        wrong = (*notes, *demonstration_faults(demonstration))
        return Preview(kind, demonstration_facts(demonstration), wrong)
    if kind == "recording":
        return _look_at_recording(path)
    from imitate.formats.session_log import summarise

    summary = summarise(path)
    unfinished = () if summary.complete else ("It was stopped or cut: it opens where it stood.",)
    return Preview(kind, session_facts(summary), (*unfinished, *summary.damage))


def _look_at_recording(path: Path) -> Preview:
    from imitate.formats.mcap_contents import contents
    from imitate.formats.recordings import open_recording

    recording = open_recording(path)
    inside = None if path.is_dir() else contents(path)
    lens, seconds = recording.intrinsics, (inside.end - inside.start) / 1e9 if inside else 0.0
    facts = [("pictures", f"{recording.count} of {lens.width} × {lens.height}, with depth")]
    if seconds > 0:
        rate = (recording.count - 1) / seconds
        facts[:0] = [("duration", f"{seconds:.2f} s"), ("rate", f"{rate:.0f} a second")]
    facts.append(("objects", "found when it is observed"))
    first = next(recording.frames(), None)
    if path.is_dir() or path.stat().st_size <= SURVEYED:
        recording.survey()
    wrong = (*recording.notes, *(inside.damage if inside else ()))
    return Preview("recording", tuple(facts), wrong, first.colour if first else None)


def read(path: Path, notes: list[str], mapping: Mapping | None = None) -> Demonstration:
    """A demonstration from its file; ``notes`` gets what the operator ought to know of it."""
    from imitate.demonstration import in_table_frame
    from imitate.formats.demonstrations import read_demonstration

    return in_table_frame(read_demonstration(path, mapping, notes))


def first_picture(path: Path, settings: Settings) -> Image:
    """The first picture (H, W, 3) that is observed of a recording, red green blue.

    Raises:
        FileError: it has none, or cannot be read.
    """
    from imitate.formats.recordings import open_recording

    first = next(open_recording(path, settings.perception).frames(), None)
    if first is None:
        raise FileError(path, "has no picture with a depth of its time", f"What it has: imitate info {path}")
    return first.colour
