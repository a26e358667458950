"""RGB-D frames → demonstration: the first view is searched, the rest tracked (the paper, Appendix A)."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import HAND, Demonstration
from imitate.errors import ImitateError
from imitate.formats.recordings import open_recording
from imitate.geometry import Array, align_signs, conjugate, inverse, read_only, rotate
from imitate.perception.ahead import ahead
from imitate.perception.block import Block
from imitate.perception.complaints import no_block, no_hand, one_frame
from imitate.perception.evidence import Body
from imitate.perception.eye import Eye, View, open_eye
from imitate.perception.fingers import FingerColours, finger_colours
from imitate.perception.first_view import FirstView
from imitate.perception.hand_tracker import HandTracker
from imitate.perception.look import look
from imitate.perception.tracker import BlockTracker, Sight
from imitate.rgbd import Intrinsics, PointCloud, RgbdFrame, RgbdSource
from imitate.settings import Perception, Settings

Progress = Callable[[int, int], None]
Span = tuple[float, float]


@dataclass(frozen=True)
class Moment:
    """One frame as it was followed.

    Attributes:
        frame: what was filmed.
        count: frames in all, as far as is known.
        sights: of the hand and each object of the first view, poses in the table's frame.
        opening: of the hand, metres; NaN where it was not seen.
        first: table and objects in the first view.
        intrinsics: of the camera.
    """

    frame: RgbdFrame
    count: int
    sights: tuple[Sight, ...]
    opening: float
    first: FirstView
    intrinsics: Intrinsics


Watch = Callable[[Moment], None]


@dataclass(frozen=True)
class Observation:
    """What was seen.

    Attributes:
        demonstration: in the table's frame: z up, z = 0 on the table, x away from the camera. Where a body
            was not seen, its pose is seven NaN.
        first: table and objects in the first view, and which of its pixels shows which.
        confidence: (T, 1+K) 0…1, of the hand and each object in each frame; 0 where it was not seen.
        lost: hand or object → the (first, last) seconds of each stretch of frames in which it was not seen.
        camera_from_table: (7,) the table's frame in the camera's.
    """

    demonstration: Demonstration
    first: FirstView
    confidence: Array
    lost: dict[str, tuple[Span, ...]]
    camera_from_table: Array

    def __post_init__(self) -> None:
        for name in ("confidence", "camera_from_table"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def lost_frames(self) -> dict[str, int]:
        """Hand or object → number of frames in which it was not seen, of those that were lost."""
        return {name: int((~self.demonstration.seen(name)).sum()) for name in self.lost}


def observe(
    recording: Path | str | RgbdSource,
    settings: Settings | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    watch: Watch | None = None,
) -> Observation:
    """Watch a recording: find table, blocks and hand, and follow them. Of the frames only poses are kept.

    Args:
        recording: its path, or the frames themselves.
        settings: ``settings.perception`` counts; default settings otherwise.
        seed: of every random draw.
        progress: called after each frame with (frames done, frames in all).
        watch: called after each frame with what was found in it.

    Raises:
        FileError: the recording cannot be read.
        ImitateError: no table, no block, no hand, or fewer than two frames.
    """
    chosen = (settings or Settings()).perception
    source: RgbdSource = open_recording(recording, chosen) if isinstance(recording, str | Path) else recording
    name = str(getattr(source, "path", "recording"))
    frames = ahead(source.frames())
    still = list(islice(frames, chosen.still_frames))
    if len(still) < 2:
        raise ImitateError(one_frame(name, len(still)))
    middle, fingers = _still(still), finger_colours(chosen, still[0].colour)
    first = _look(name, middle, source.intrinsics, chosen, seed, fingers)
    eye = open_eye(source.intrinsics, first.table, fingers)
    blocks = {thing.name: thing.block for thing in first.objects}
    if not blocks:
        raise ImitateError(no_block(name, first, chosen))
    trackers = _Trackers(first, eye, middle, chosen, seed)
    t: list[float] = []
    rows: list[list[Sight]] = []
    openings: list[float] = []
    for frame in _replayed(still, frames):
        sights = trackers.follow(View(eye, frame, len(t)))
        rows.append(sights)
        openings.append(trackers.opening)
        t.append(frame.t)
        count = max(source.count, len(t))
        if progress:
            progress(len(t), count)
        if watch:
            watch(Moment(frame, count, tuple(sights), openings[-1], first, source.intrinsics))
    return _observation(name, np.array(t), rows, np.array(openings), blocks, first, chosen)


class _Trackers:
    """The hand's and the blocks', each with its own draws."""

    def __init__(self, first: FirstView, eye: Eye, still: RgbdFrame, settings: Perception, seed: int) -> None:
        points = View(eye, still, 0).everything()
        self._hand = HandTracker(settings)
        self._blocks = []
        for k, thing in enumerate(first.objects):
            hue = thing.name.rstrip("0123456789") if thing.has_hue else None
            own = points[first.labels == k + 1]
            surface = rotate(conjugate(thing.block.pose[3:]), own - thing.block.pose[:3])
            self._blocks.append(BlockTracker(thing.block, hue, surface, settings))
        seeds = np.random.SeedSequence(seed).spawn(1 + len(self._blocks))
        self._generators = [np.random.default_rng(s) for s in seeds]

    @property
    def opening(self) -> float:
        """Of the hand in the last frame, metres."""
        return self._hand.opening

    def follow(self, view: View) -> list[Sight]:
        """The hand and the blocks in this frame."""
        sights = [self._hand.follow(view, self._generators[0])]
        bodies: list[Body] = [self._hand, *self._blocks]
        for block, generator in zip(self._blocks, self._generators[1:], strict=True):
            sights.append(block.follow(view, bodies, self._hand.motion, generator))
        for block in self._blocks:
            block.lie(self._blocks)
        return sights


def _look(
    name: str,
    still: RgbdFrame,
    intrinsics: Intrinsics,
    settings: Perception,
    seed: int,
    fingers: FingerColours,
) -> FirstView:
    points = (intrinsics.rays() * np.where(still.depth > 0, still.depth, np.nan)[..., None]).reshape(-1, 3)
    cloud = PointCloud(points, still.colour.reshape(-1, 3), still.depth.shape)
    return look(name, cloud, settings, seed, fingers)


def _still(frames: list[RgbdFrame]) -> RgbdFrame:
    """The median of several frames, pixel by pixel."""
    depth = np.stack([frame.depth for frame in frames])
    readings = np.where(depth > 0, depth, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a pixel without any reading
        median = np.nan_to_num(np.nanmedian(readings, axis=0))
    colour = np.median(np.stack([frame.colour for frame in frames]), axis=0)
    return RgbdFrame(frames[0].t, colour.astype(np.uint8), median.astype(np.float32))


def _replayed(first: list[RgbdFrame], rest: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
    """The first frames, forgotten as they are given, then the rest."""
    while first:
        yield first.pop(0)
    yield from rest


def _observation(
    name: str,
    t: Array,
    rows: list[list[Sight]],
    openings: Array,
    blocks: dict[str, Block],
    first: FirstView,
    settings: Perception,
) -> Observation:
    missing = np.full(7, np.nan)
    poses = np.array([[missing if s.pose is None else s.pose for s in row] for row in rows])
    confidence = np.array([[s.confidence for s in row] for row in rows])
    seen = ~np.isnan(poses[..., 0])
    if not seen[:, 0].any():
        raise ImitateError(no_hand(name, settings))
    # What was found in the first view but cannot be followed as a block is no object of the demonstration.
    kept = [k for k in range(poses.shape[1]) if k == 0 or seen[:, k].sum() > 1]
    poses, confidence, seen = poses[:, kept], confidence[:, kept], seen[:, kept]
    blocks = {body: blocks[body] for k, body in enumerate(blocks) if k + 1 in kept}
    for k in range(poses.shape[1]):
        poses[seen[:, k], k] = align_signs(poses[seen[:, k], k])
    demonstration = Demonstration(
        t=t,
        hand=poses[:, 0],
        objects=poses[:, 1:],
        object_names=tuple(blocks),
        object_sizes=np.array([block.size for block in blocks.values()]),
        opening=openings,
    )
    lost = {body: _spans(t, ~seen[:, k]) for k, body in enumerate((HAND, *blocks)) if not seen[:, k].all()}
    camera_from_table = inverse(first.table.table_from_camera)
    return Observation(demonstration, first, confidence, lost, camera_from_table)


def _spans(t: Array, missing: NDArray[np.bool_]) -> tuple[Span, ...]:
    """First and last times of each run of missing frames."""
    edges = np.diff(np.concatenate([[False], missing, [False]]).astype(int))
    starts, ends = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0) - 1
    return tuple((float(t[a]), float(t[b])) for a, b in zip(starts, ends, strict=True))
