"""Pictures of two streams → frames: paired, decoded, in metres, registered, and checked on the way."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.camera_messages import Picture
from imitate.formats.clock import SECOND, astray_note, gaps_in_words
from imitate.formats.distances import check_distances, to_metres
from imitate.formats.pairing import COLOUR, DEPTH, Stamped, Tally, paired
from imitate.formats.picture_times import steady
from imitate.formats.pictures import Pixels, is_depth
from imitate.formats.registration import Registration
from imitate.rgbd import RgbdFrame

MUCH_LEFT_OUT = 0.1
"""share of a recording's frames from which on what is left out counts as a loss."""
MILLIMETRE = 0.001
"""m of one step of an integer depth in ROS (REP 118) and Foxglove."""

Pictures = Iterator[Stamped[Picture]]
Pairs = Iterator[tuple[Stamped[Picture], Stamped[Picture]]]


@dataclass(frozen=True)
class Streams:
    """Two streams of pictures, and what makes frames of them.

    Attributes:
        path: of the recording, for messages.
        colour, depth: topics, or whatever else names the streams in messages.
        registration: of the two cameras, for pictures of the sizes of its lenses.
        unit: metres of one step of an integer depth; ``float_unit`` of 1.0 in a float depth.
        unit_given: whether the operator gave the unit, so that it is not doubted.
        within: seconds, the most between the pictures of one frame.
    """

    path: Path
    colour: str
    depth: str
    registration: Registration
    unit: float = MILLIMETRE
    float_unit: float = 1.0
    unit_given: bool = False
    within: float = 0.04

    def pairs(self, colours: Pictures, depths: Pictures, tally: Tally, notes: list[str]) -> Pairs:
        """Colour and depth of each frame, not decoded yet.

        Args:
            colours, depths: the pictures, in nearly the order in which they were taken.
            tally: counts what is read.
            notes: gets what was left out, at the end.

        Raises:
            FileError: nothing pairs, or a clock was set.
        """
        kept = (self._steady(COLOUR, colours, tally), self._steady(DEPTH, depths, tally))
        pictures = heapq.merge(*kept, key=lambda one: one.time)
        times: list[int] = []
        for pair in paired(pictures, round(self.within * SECOND), tally):
            times.append(pair[DEPTH].time)
            yield pair
        if not times:
            raise self._unpaired(tally)
        found = (*self._left_out(tally), *gaps_in_words((np.array(times) - times[0]) / SECOND))
        notes += [note for note in found if note not in notes]

    def frames(self, pairs: Pairs) -> Iterator[RgbdFrame]:
        """Every pair as a frame, t in seconds from the first depth picture of a pair.

        Raises:
            FileError: a picture cannot be decoded or is of another size than its calibration, no depth is
                read, or depths cannot be metres.
        """
        first: int | None = None
        checked = self.unit_given
        for colour, depth in pairs:
            metres = self._metres(depth.held)
            first = depth.time if first is None else first
            if not checked and metres.any():
                unit = self.float_unit if depth.held.form.startswith("32FC1") else self.unit
                what = f"{self.depth} ({depth.held.form or 'unnamed encoding'})"
                check_distances(self.path, what, metres[metres > 0], unit)
                checked = True
            registered = self.registration.registered(self._colour(colour.held), metres)
            yield RgbdFrame((depth.time - first) / SECOND, *registered)
        if not checked:
            raise FileError(
                self.path,
                f"{self.depth} has no reading in any picture: every depth is 0",
                "Check the depth camera, or name another topic with --depth-topic.",
            )

    def _steady(self, kind: int, pictures: Pictures, tally: Tally) -> Iterator[Stamped[Picture]]:
        def astray(_: Stamped[Picture]) -> None:
            tally.astray[kind] += 1

        return steady(self.path, (self.colour, self.depth)[kind], pictures, lambda one: one.time, astray)

    def _left_out(self, tally: Tally) -> Iterator[str]:
        for stream, seen, astray in zip((self.colour, self.depth), tally.seen, tally.astray, strict=True):
            if astray:
                yield astray_note(f"pictures of {stream}", astray, seen + astray)
        alone = sum(tally.seen) - 2 * tally.paired
        if alone > MUCH_LEFT_OUT * sum(tally.seen):
            yield (
                f"{alone} of {sum(tally.seen)} pictures are left out: no other within {self.within:g} s "
                "(--pair-within)"
            )

    def _colour(self, picture: Picture) -> NDArray[np.uint8]:
        pixels = self._decoded(picture, self.colour, False)
        return np.repeat(pixels[..., None], 3, axis=2) if pixels.ndim == 2 else pixels

    def _metres(self, picture: Picture) -> NDArray[np.float32]:
        pixels = self._decoded(picture, self.depth, True)
        return to_metres(pixels, self.float_unit if pixels.dtype.kind == "f" else self.unit)

    def _decoded(self, picture: Picture, stream: str, depth: bool) -> Pixels:
        pixels = picture.decode()
        if pixels is None or is_depth(pixels) != depth:
            raise undecodable(self.path, stream, picture, "depth" if depth else "colour")
        lens = self.registration.depth if depth else self.registration.colour
        check_size(self.path, stream, pixels, (lens.intrinsics.height, lens.intrinsics.width))
        return pixels

    def _unpaired(self, tally: Tally) -> FileError:
        colours, depths = tally.seen
        if tally.nearest is not None:
            apart = f"; the nearest two are {tally.nearest / 1e9:.3f} s apart"
        elif len(tally.spans) == 2:
            one, other = tally.spans[COLOUR], tally.spans[DEPTH]
            gap = max(one[0] - other[1], other[0] - one[1]) / 1e9
            apart = f"; the clocks lie {gap:.3f} s apart"
        else:
            apart = ""
        return FileError(
            self.path,
            f"colour and depth never pair within {self.within:g} s: {colours} pictures in {self.colour}, "
            f"{depths} in {self.depth}{apart}",
            "Pass more seconds with --pair-within, or record both with one clock.",
        )


def check_size(path: Path, stream: str, pixels: NDArray[Any], expected: tuple[int, int]) -> None:
    """Raises FileError when a picture is of another size (H, W) than expected."""
    height, width = pixels.shape[:2]
    if (height, width) != expected:
        raise FileError(
            path,
            f"{stream} holds pictures of {width}×{height}, its calibration says {expected[1]}×{expected[0]}",
            "Name the calibration of these pictures with --calibration-topic, or pass it with --intrinsics "
            "FX,FY,CX,CY.",
        )


def damaged(path: Path, words: str) -> FileError:
    """What to say of a recording that is not whole."""
    remedy = "Record or copy it again; or use as much as can be read: imitate observe FILE --salvage."
    return FileError(path, f"is damaged: {words}", remedy)


def undecodable(path: Path, stream: str, picture: Picture, kind: str) -> FileError:
    """What to say of a picture that is not what it should be."""
    form = picture.form or "nameless"
    remedy = (
        "Colour may be rgb8, bgr8, rgba8, bgra8, mono8, Bayer or YUV 4:2:2, JPEG or PNG; depth 16UC1, "
        "mono16, 32FC1, 16-bit PNG or compressedDepth in PNG."
    )
    return FileError(path, f"{stream} holds a {form} picture that cannot be decoded as {kind}", remedy)
