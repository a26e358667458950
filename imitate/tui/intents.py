"""What screens ask of the application, and what its workers report to it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from textual.message import Message

from imitate.demonstration import Demonstration
from imitate.events import Event, Reproduced
from imitate.formats.kind import Kind
from imitate.skill import Segment
from imitate.tui.again import Checking, Depth, Library, Trying
from imitate.tui.album import Album, Shot
from imitate.tui.film import Film
from imitate.tui.series import Series
from imitate.tui.sighting import Sighting
from imitate.tui.state import Interval, Step

if TYPE_CHECKING:
    from imitate.segmentation import Doubt
    from imitate.tui.again import Report


@dataclass
class Open(Message):
    """Open a file."""

    path: Path


class Decided(Message):
    """The segments, or how sure their boundaries are, are not what they were."""


class Weigh(Message):
    """Find out how sure the boundaries are, and what is far less likely than found, unless it is known."""


@dataclass
class Weighed(Message):
    """It is known for these segments; ``along``: what each frame says for each object to move along."""

    segments: tuple[Segment, ...]
    changes: tuple[Interval, ...]
    doubts: tuple[Doubt, ...]
    along: Series


class Learn(Message):
    """Start learning."""


@dataclass
class Choose(Message):
    """Learn with these values of the form from the next start on."""

    values: dict[str, str]


class Stop(Message):
    """Stop after the present trial."""


class Pause(Message):
    """Wait after the present trial."""


class Skip(Message):
    """Give the present formulation up after the present trials."""


class GoOn(Message):
    """Go on after a pause, or with a session that was stopped."""


class Reproduce(Message):
    """Run the task from the starts that are chosen."""


class Films(Message):
    """Read the session's trials, unless they are read."""


@dataclass
class Verify(Message):
    """Replay the session."""

    depth: Depth


class Pictures(Message):
    """Read the recording's pictures, unless they are read."""


class View(Message):
    """Open the session in Rerun's viewer."""


@dataclass
class Viewed(Message):
    """Rerun's viewer was started, or could not be."""

    of: Library


@dataclass
class Said(Message):
    """A work on a finished session said something; None at its end."""

    of: Trying | Checking | Library | Album
    said: Film | Reproduced | Report | Shot | float | None


@dataclass
class Go(Message):
    """Show a step."""

    step: Step


@dataclass
class Opened(Message):
    """A demonstration was read or observed, and cut; ``notes`` say what ought to be known of how."""

    source: Path
    kind: Kind
    demonstration: Demonstration
    segments: tuple[Segment, ...]
    notes: tuple[str, ...] = ()


@dataclass
class Recording(Message):
    """The file is a recording: it is to be observed."""

    source: Path


@dataclass
class Wear(Message):
    """Observe the recording anew with these colours of the left and right finger."""

    left: str
    right: str


@dataclass
class Sighted(Message):
    """Frames of the recording that were tracked since the last ones."""

    sighting: Sighting


@dataclass
class Tracked(Message):
    """Share of the frames that were tracked, of a recording that is learned from."""

    share: float


@dataclass
class Recorded(Message):
    """A recorded session was read."""

    source: Path
    events: tuple[Event, ...]


@dataclass
class Happened(Message):
    """Something happened in the session that is being learned."""

    event: Event


class Ended(Message):
    """The engine has nothing more to say."""


@dataclass
class Failed(Message):
    """Work of a kind ("open", "observe", "split" …) failed; ``error`` is written for the person."""

    work: str
    error: str
