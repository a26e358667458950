"""A body's poses over time, and how one body's frame leads to another's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.clock import Both
from imitate.geometry import Array, compose, relative, resample

GAP = 5.0
"""times a track's usual step; what lies between samples further apart was not seen."""
SHORTEST_GAP = 0.2
"""s; and no shorter than this."""

Times = NDArray[np.int64]


@dataclass(frozen=True)
class Track:
    """Poses of one body over time.

    Attributes:
        frame: that they are given in.
        times: (N,) nanoseconds, strictly increasing.
        poses: (N, 7).
        fixed: whether they hold at all times.
        taken: stamp and log time of every sample, those left out as well.
        astray: how many samples are left out: their times were off those around them.
        logged: whether the times are from the log, though it has stamps or the log is of another clock than
            the other tracks' stamps.
    """

    frame: str
    times: Times
    poses: Array
    fixed: bool = False
    taken: Sequence[Both] = ()
    astray: int = 0
    logged: bool = False

    @property
    def moves(self) -> bool:
        """Whether it says when it was where: a single pose holds at all times."""
        return not self.fixed and len(self.taken) > 1

    def at(self, times: Times) -> Array:
        """(S, 7) poses at other times: interpolated, and seven NaN in a gap or beyond the track's ends."""
        if self.fixed or len(self.times) == 1:
            return np.repeat(self.poses[-1:], len(times), axis=0)
        step = float(np.median(np.diff(self.times)))
        gap = max(GAP * step, SHORTEST_GAP * 1e9)
        after = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        apart = self.times[after] - self.times[after - 1]
        beyond = np.maximum(self.times[0] - times, times - self.times[-1])
        met = np.isin(times, self.times)
        origin = self.times[0]
        found = resample((self.times - origin) / 1e9, self.poses, (times - origin) / 1e9)
        exact = self.poses[np.minimum(np.searchsorted(self.times, times), len(self.times) - 1)]
        found[met] = exact[met]
        found[~met & ((apart > gap) | (beyond > step))] = np.nan
        return found


@dataclass(frozen=True)
class Tracks:
    """Every track of a file.

    Attributes:
        topics: topic → track, of topics that give poses.
        frames: frame → track in its parent frame, of transforms.
        numbers: topic → track whose positions' x it is, of numbers that may be the hand's opening.
    """

    path: Path
    topics: Mapping[str, Track]
    frames: Mapping[str, Track]
    numbers: Mapping[str, Track]

    def times(self, source: Track) -> Times:
        """Of the link with the most samples, from a track up to the root of its frames."""
        return max((link.times for link in self.links(source)), key=len)

    def top(self, source: Track) -> str:
        """The frame at the root of a track's frames."""
        return list(self.links(source))[-1].frame

    def within(self, source: Track, root: str, times: Times) -> Array:
        """(S, 7) a track's poses in the frame ``root``.

        Raises:
            FileError: no transform leads there.
        """
        poses, frame = source.at(times), source.frame
        while frame != root and frame in self.frames:
            poses, frame = compose(self.frames[frame].at(times), poses), self.frames[frame].frame
        if frame == root:
            return poses
        if root in self.frames and self.top(self.frames[root]) == frame:
            return relative(self.within(self.frames[root], frame, times), poses)
        raise FileError(
            self.path,
            f"gives poses in several frames, and no transform leads from {source.frame!r} to {root!r}",
            "Record the transforms as well, or give all in one frame.",
        )

    def links(self, source: Track) -> Iterator[Track]:
        """A track, and those of the frames from its own up to the root."""
        for _ in range(len(self.frames) + 1):
            yield source
            if source.frame not in self.frames:
                return
            source = self.frames[source.frame]
        raise FileError(self.path, f"has transforms in a circle through {source.frame!r}")
