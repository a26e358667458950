"""A folder in the layout of the TUM RGB-D benchmark: rgb.txt, depth.txt and the pictures they list.

Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS 2012; file formats at
cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats: depth is a 16-bit PNG of 5000 steps a metre,
registered to colour; a line of a list is a time in seconds and a file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from imitate.errors import FileError
from imitate.formats import pictures
from imitate.formats.camera_messages import Picture
from imitate.formats.clock import NAMES, epoch_unit
from imitate.formats.frames import Pairs, Streams
from imitate.formats.mapping import TIMES
from imitate.formats.pairing import COLOUR, DEPTH, Stamped, Tally
from imitate.formats.registration import Registration
from imitate.formats.rgbd_topics import lens_of
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception
from imitate.text_file import read_text

UNIT = 1 / 5000
"""m of one step of depth."""
LISTS = ("rgb.txt", "depth.txt")
CALIBRATIONS = ("calibration.txt", "camera.txt", "intrinsics.txt")
"""files that may hold fx fy cx cy and any distortion k1 k2 p1 p2 k3, or the 3×3 matrix of the camera."""

UNORDERED = 0.1
"""share of a list's lines that go back in time from which on it is in no order, and is sorted."""

Line = tuple[int, Path]


@dataclass
class TumFolder:
    """A folder, opened.

    Attributes:
        lists: nanoseconds and file of each picture, colour and depth.
        notes: what the operator ought to know, in words; more may come while the frames are read.
        tally: what became of the pictures when they were last read.
    """

    path: Path
    lists: tuple[list[Line], list[Line]]
    streams: Streams
    notes: list[str] = field(default_factory=list)
    tally: Tally = field(default_factory=Tally)

    @property
    def left_out(self) -> float:
        """Share of the frames that could be that are not, once they are read."""
        return self.tally.left_out

    @property
    def intrinsics(self) -> Intrinsics:
        """Of every frame."""
        return self.streams.registration.intrinsics

    @property
    def count(self) -> int:
        """How many frames there are at most."""
        return min(map(len, self.lists))

    def frames(self) -> Iterator[RgbdFrame]:
        """Every frame in order, read as it is asked for; t in seconds from the first.

        Raises:
            FileError: as `survey`, as `Streams.frames`, or a file that is listed and missing.
        """
        return self.streams.frames(self._pairs())

    def survey(self) -> None:
        """Goes through the lists alone; ``notes`` and ``left_out`` are known then.

        Raises:
            FileError: as `Streams.pairs`.
        """
        for _ in self._pairs():
            pass

    def _pairs(self) -> Pairs:
        self.tally = Tally()
        colours, depths = (_stamped(kind, self.lists[kind]) for kind in (COLOUR, DEPTH))
        return self.streams.pairs(colours, depths, self.tally, self.notes)


def open_tum(path: Path, settings: Perception) -> TumFolder:
    """What a folder holds, from its lists and its first picture.

    Raises:
        FileError: a list is missing, empty or cannot be understood, or nothing calibrates the camera.
    """
    notes: list[str] = []
    colours, depths = (_listed(path, name, notes) for name in LISTS)
    first = _picture(colours[0][1], 0).decode()
    if first is None:
        raise FileError(colours[0][1], "is no picture", f"It is the first that {path / LISTS[0]} lists.")
    numbers = settings.intrinsics or _calibration(path)
    lens = lens_of(numbers, (first.shape[0], first.shape[1]))
    unit = settings.depth_unit
    streams = Streams(
        path,
        *LISTS,
        Registration(lens, lens),
        unit=unit or UNIT,
        unit_given=bool(unit),
        within=settings.pair_within,
    )
    return TumFolder(path, (colours, depths), streams, notes)


def _stamped(kind: int, lines: list[Line]) -> Iterator[Stamped[Picture]]:
    return (Stamped(kind, time, _picture(file, time)) for time, file in lines)


def _picture(file: Path, time: int) -> Picture:
    return Picture(time, "", file.name, partial(_decoded, file))


def _decoded(file: Path) -> pictures.Pixels | None:
    try:
        return pictures.compressed(file.suffix, file.read_bytes())
    except OSError as error:
        raise FileError(file, f"is listed but cannot be read ({error.strerror})", "Copy it again.") from None


def _listed(path: Path, name: str, notes: list[str]) -> list[Line]:
    remedy = "A line is a time in seconds and a file: 1305031102.175304 rgb/1305031102.175304.png"
    try:
        text = read_text(path / name)
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path / name, f"cannot be read as text ({error})", remedy) from None
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            ticks = Decimal(words[0])
            int(ticks)  # raises where it is no number
            lines.append((ticks, path / words[1]))
        except (InvalidOperation, IndexError, ValueError, OverflowError):
            raise FileError(path / name, f"line {number} is {line.strip()!r}", remedy) from None
    if not lines:
        raise FileError(path / name, "lists no picture", remedy)
    return _in_order(_in_nanoseconds(name, lines, notes))


def _in_nanoseconds(name: str, lines: list[tuple[Decimal, Path]], notes: list[str]) -> list[Line]:
    unit = epoch_unit(np.array([float(ticks) for ticks, _ in lines])) or "s"
    if unit != "s":
        notes.append(f"{name} has times in {NAMES[unit]} since 1970, and is read as such")
    return [(int(ticks * round(TIMES[unit] * 1e9)), file) for ticks, file in lines]


def _in_order(lines: list[Line]) -> list[Line]:
    """As they are where nearly all are in order, so that one that is off is seen; else by their times."""
    back = sum(later < earlier for (earlier, _), (later, _) in pairwise(lines))
    return sorted(lines) if back > UNORDERED * len(lines) else lines


def _calibration(path: Path) -> tuple[float, ...]:
    """fx, fy, cx, cy and any distortion, from the first file there is."""
    remedy = (
        "Pass the camera's own numbers with --intrinsics FX,FY,CX,CY (525,525,319.5,239.5 for the "
        f"benchmark's recordings), or write them into {CALIBRATIONS[0]} in the folder."
    )
    for name in CALIBRATIONS:
        if (path / name).exists():
            text = (path / name).read_text(encoding="utf-8-sig", errors="replace")
            words = " ".join(line.partition("#")[0] for line in text.splitlines()).replace(",", " ").split()
            try:
                numbers = tuple(map(float, words))
            except ValueError:
                numbers = ()
            if len(numbers) == 9 and numbers[6:] == (0, 0, 1):
                return numbers[0], numbers[4], numbers[2], numbers[5]
            if len(numbers) in (4, 8, 9):
                return numbers
            raise FileError(path / name, f"holds {' '.join(words[:9])!r}, not fx fy cx cy", remedy)
    raise FileError(path, f"has no calibration of its camera: looked for {', '.join(CALIBRATIONS)}", remedy)
