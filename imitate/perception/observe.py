"""RGB-D recording → demonstration: the first view is searched, the rest tracked (the paper, Appendix A)."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

import numpy as np

from imitate.demonstration import HAND, Demonstration
from imitate.errors import ImitateError
from imitate.formats.recordings import open_recording
from imitate.geometry import Array, align_signs, inverse, read_only, resample
from imitate.perception.block import Block, block_of_cluster, fit_block
from imitate.perception.colour import HUES, dominant_hue, is_hue
from imitate.perception.eye import Eye, open_eye
from imitate.perception.shapes import Pixels
from imitate.perception.tabletop import clusters
from imitate.perception.tracker import BlockTracker, HandTracker
from imitate.rgbd import RgbdFrame
from imitate.settings import Perception, Settings

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Observation:
    """What was seen.

    Attributes:
        demonstration: in the table's frame: z up, z = 0 on the table, x away from the camera.
        lost: hand or object → number of frames in which it was not seen; its pose there is interpolated.
        camera_from_table: (7,) the table's frame in the camera's.
    """

    demonstration: Demonstration
    lost: dict[str, int]
    camera_from_table: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "camera_from_table", read_only(self.camera_from_table))


def observe(
    path: Path | str, settings: Settings | None = None, seed: int = 0, progress: Progress | None = None
) -> Observation:
    """Watch a recording: find table, blocks and hand, and follow them.

    Args:
        path: the recording.
        settings: ``settings.perception`` counts; default settings otherwise.
        seed: of every random draw.
        progress: called after each frame with (frames done, frames in all).

    Raises:
        FileError: the recording cannot be read.
        ImitateError: no table, no block, no hand, or fewer than two frames.
    """
    chosen = (settings or Settings()).perception
    recording = open_recording(path)
    generator = np.random.default_rng(seed)
    frames = recording.frames()
    first = list(islice(frames, chosen.still_frames))
    if len(first) < 2:
        raise ImitateError(f"{path}: {len(first)} frame(s); a demonstration needs at least 2.")
    still = _still(first)
    eye = open_eye(recording.intrinsics, still.depth, seed)
    blocks = find_blocks(eye.pixels(still), eye, chosen, generator)
    if not blocks:
        raise ImitateError(
            f"{path}: no block on the table in the first {len(first)} frames. Blocks are coloured, at least "
            f"1.5 cm high, apart from each other, and not {chosen.left_finger} or {chosen.right_finger}."
        )
    trackers = [BlockTracker(block, name, chosen) for name, block in blocks.items()]
    hand = HandTracker(chosen)
    t, rows = [], []
    for frame in chain(first, frames):
        pixels = eye.pixels(frame)
        poses = [hand.follow(pixels, frame.t, eye, generator)]
        poses += [tracker.follow(pixels, frame.t, eye, generator, trackers) for tracker in trackers]
        t.append(frame.t)
        rows.append(poses)
        if progress:
            progress(len(t), recording.count)
    return _observation(path, t, rows, blocks, eye, chosen)


def find_blocks(
    pixels: Pixels, eye: Eye, settings: Perception, generator: np.random.Generator
) -> dict[str, Block]:
    """Name → block, from a view without motion; named by hue, numbered when repeated, the largest first."""
    points = pixels.points()
    hand = is_hue(pixels.hue, settings.left_finger) | is_hue(pixels.hue, settings.right_finger)
    found: dict[str, Block] = {}
    counts: Counter[str] = Counter()
    for cluster in clusters(points, (pixels.depth > 0) & ~hand & eye.over_table(points)):
        hue = dominant_hue(pixels.hue[cluster])
        if hue not in HUES:
            continue
        rough = block_of_cluster(points[cluster])
        window = eye.window(rough.pose[None, :3], float(np.linalg.norm(rough.size)), 4 * settings.pixels)
        around = pixels.where(window)
        own = is_hue(around.hue, hue)
        counts[hue] += 1
        name = hue if counts[hue] == 1 else f"{hue}{counts[hue]}"
        found[name], _ = fit_block(rough, around, own, settings.depth_noise / 2, generator)
    return dict(sorted(found.items()))


def _still(frames: list[RgbdFrame]) -> RgbdFrame:
    """The median of several frames, pixel by pixel."""
    depth = np.stack([frame.depth for frame in frames])
    readings = np.where(depth > 0, depth, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a pixel without any reading
        median = np.nan_to_num(np.nanmedian(readings, axis=0))
    colour = np.median(np.stack([frame.colour for frame in frames]), axis=0)
    return RgbdFrame(frames[0].t, colour.astype(np.uint8), median.astype(np.float32))


def _observation(
    path: Path | str,
    t: list[float],
    rows: list[list[Array | None]],
    blocks: dict[str, Block],
    eye: Eye,
    settings: Perception,
) -> Observation:
    times = np.array(t)
    lost: dict[str, int] = {}
    tracks = []
    for k, name in enumerate((HAND, *blocks)):
        seen = np.array([poses[k] is not None for poses in rows])
        if not seen.any():
            raise ImitateError(
                f"{path}: no hand. Wear a {settings.left_finger} finger on the left and a "
                f"{settings.right_finger} one on the right, or name their hues in the settings."
            )
        found = np.array([pose for poses in rows if (pose := poses[k]) is not None])
        tracks.append(align_signs(resample(times[seen], found, times)))
        if not seen.all():
            lost[name] = int((~seen).sum())
    demonstration = Demonstration(
        t=times,
        hand=tracks[0],
        objects=np.stack(tracks[1:], axis=1),
        object_names=tuple(blocks),
        object_sizes=np.array([block.size for block in blocks.values()]),
    )
    return Observation(demonstration, lost, inverse(eye.table_from_camera))
