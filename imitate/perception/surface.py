"""A body that is no box, followed by the surface that the first view showed of it.

Each of the surface's points is looked up where a guess would put it in the picture.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, conjugate, rotate
from imitate.perception.evidence import STRANGE, UNREAD, Evidence, Fit
from imitate.perception.eye import View, Window
from imitate.perception.shapes import LIMIT, Float, Places, places

POINTS = 400
"""of a surface that are compared, at most."""


class SurfaceEvidence:
    """What a window of a frame says about a body of known surface.

    Args:
        view: the frame.
        window: of it, every pixel.
        seen: the same pixels as evidence for the body.
        surface: (S, 3) its points in its own frame, metres.
        noise: standard deviation of depth, metres.
    """

    def __init__(self, view: View, window: Window, seen: Evidence, surface: Array, noise: float) -> None:
        self._seen, self._surface, self._noise = seen, surface.astype(np.float32), noise
        self._intrinsics, self._pose = view.eye.intrinsics, view.eye.table_from_camera
        self._corner = window[0].start, window[1].start
        self._depth = np.ascontiguousarray(view.frame.depth[window])
        # What each pixel is: the body's own, another thing, or one that is known to be another body's.
        kind = np.ones(self._depth.size, np.int8)
        kind[seen.order[: seen.edges[1]]] = 0
        kind[seen.order[seen.edges[3] :]] = 2
        self._kind = kind

    @property
    def count(self) -> int:
        """Of the pixels that could show the body."""
        return self._seen.count

    def points(self) -> Array:
        """(A, 3) the readings that could show the body, in the table's frame."""
        return self._seen.points()

    def score(self, guesses: Places) -> Float:
        """(N,) log-likelihoods of the body at N places."""
        cost, _, _ = self._costs(guesses)
        return np.asarray(-cost.sum(axis=1), np.float32)

    def fit(self, pose: Array) -> Fit:
        """How one pose (7,) agrees."""
        cost, against, hidden = (part[0] for part in self._costs(places(pose[None])))
        shown = len(cost) - int(against.sum()) - int(hidden.sum())
        return Fit(shown, int(against.sum()), int(hidden.sum()), 0, -float(cost.mean()))

    def _costs(self, guesses: Places) -> tuple[Float, Float, Float]:
        """(N, S) log-likelihoods lost at each point, and whether it is against the pose or hidden."""
        u, v, z = self._projected(guesses)
        height, width = self._depth.shape
        outside = (u < 0) | (u >= width) | (v < 0) | (v >= height)
        at = np.where(outside, 0, v * width + u)
        depth, kind = self._depth.reshape(-1)[at], self._kind[at]
        residual = (z - depth) / np.float32(self._noise)
        cost = np.minimum(residual**2 / 2, LIMIT)
        if self._seen.coloured:
            cost[(kind == 1) & (np.abs(residual) <= 3)] = LIMIT
        unread = depth == 0
        cost[unread] = np.where(kind[unread] == 0, 0, UNREAD)
        strange = kind == 1 if self._seen.coloured else kind < 2
        hidden = outside | (kind == 2) | (strange & (residual > 3)) | (unread & (kind > 0))
        cost[hidden] = STRANGE
        return cost, ~hidden & (cost >= LIMIT), hidden

    def _projected(self, guesses: Places) -> tuple[Array, Array, Float]:
        """(N, S) columns and rows in the window, and depths, of the surface's points."""
        i, camera = self._intrinsics, conjugate(self._pose[3:])
        turned = Rotation.from_quat(camera).as_matrix() @ guesses.turned
        start = rotate(camera, guesses.at - self._pose[:3])
        seen = np.matmul(turned.astype(np.float32), self._surface.T) + start[..., None].astype(np.float32)
        x, y, z = seen[:, 0], seen[:, 1], np.maximum(seen[:, 2], np.float32(0.05))
        u = np.rint(i.fx * x / z + i.cx).astype(np.intp) - self._corner[1]
        v = np.rint(i.fy * y / z + i.cy).astype(np.intp) - self._corner[0]
        return u, v, z
