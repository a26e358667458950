"""The table in a view: of several planes, the one that carries things."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from imitate.errors import ImitateError
from imitate.geometry import Array, inverse, read_only, rotate
from imitate.perception.noise import kinect_noise, scatter
from imitate.perception.shapes import Mask

PLANES = 6
"""planes that are looked at, the largest first."""
SHARE = 0.01
"""of a view's surface that a plane must hold to be looked at."""
SMALLEST = 0.02
"""m² of a tabletop that are seen, at least."""
DRAWS = 4000
"""of RANSAC for each plane."""
COARSE = 0.01
"""m, the grid on which planes and what they carry are judged."""
GATE = 3.0
"""standard deviations of a reading's depth within which a point lies on a plane."""
ROOM = 0.5
"""m above the table in which objects are looked for; what reaches higher is a wall or a person."""
LONGEST = 0.45
"""m along the table, the longest thing that a table is believed to carry; furniture is longer."""
BESIDE = 0.03
"""m beyond the table's visible outline in which a thing may stand on it, hiding it there."""
GAP = 0.05
"""m between parts of one tabletop, across what stands on it."""
_FEWEST = 1000
"""readings, below which no table is looked for."""


def open3d() -> Any:
    """The open3d module.

    Raises:
        ImitateError: it cannot be imported; the message holds the line that installs what it lacks.
    """
    try:
        import open3d as module
    except (ImportError, OSError) as error:
        raise ImitateError(
            f"open3d, which finds the table, cannot be imported ({error}). This installs what it needs: "
            "python -m pip install 'open3d-cpu==0.19.*' && "
            "sudo apt-get install -y libgl1 libgomp1 libx11-6 libusb-1.0-0"
        ) from None
    return module


@dataclass(frozen=True)
class Table:
    """The plane that things stand on.

    Attributes:
        plane: (4,) a b c d with a·x + b·y + c·z + d = 0 in the camera's frame; (a b c) a unit normal
            towards the camera.
        inliers: points on it.
        table_from_camera: (7,) the table's frame: z up, z = 0 on it, x away from the camera.
        outline: (K, 2) corners of a convex shape around what is seen of it, in its own x and y, metres.
        scatter: the sensor's noise, as a multiple of a Kinect's.
    """

    plane: Array
    inliers: int
    table_from_camera: Array
    outline: Array
    scatter: float

    def __post_init__(self) -> None:
        for name in ("plane", "table_from_camera", "outline"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def low(self) -> Array:
        """(2,) its least x and y."""
        return np.asarray(self.outline.min(axis=0))

    @property
    def high(self) -> Array:
        """(2,) its greatest x and y."""
        return np.asarray(self.outline.max(axis=0))

    def placed(self, points: Array) -> Array:
        """Points (N, 3) of the camera's frame in the table's."""
        return self.table_from_camera[:3] + rotate(self.table_from_camera[3:], points)

    def noise(self, depth: Array) -> Array:
        """(N,) standard deviation in metres of readings at ``depth`` metres, along the optical axis."""
        return self.scatter * kinect_noise(depth)

    def height_noise(self, points: Array) -> Array:
        """(N,) standard deviation in metres of the height above the table of points (N, 3), the camera's."""
        return self.noise(points[:, 2]) * _steepness(points, self.plane[:3])

    def reaches(self, placed: Array) -> Mask:
        """(N,) which points (N, 3) of the table's frame are over it, or close beside it."""
        edges = np.roll(self.outline, -1, axis=0) - self.outline
        outwards = np.stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)
        beyond = placed[:, :2] @ outwards - np.einsum("kj,jk->k", self.outline, outwards)
        return np.asarray(beyond.max(axis=1) < BESIDE)


def find_table(points: Array, seed: int) -> Table:
    """The plane that carries most; where none carries anything, the largest.

    Several planes are found by RANSAC (the paper, Appendix A, takes the largest). A plane carries the
    compact things that stand on it within its outline: a table's objects, but not a table on a floor.

    Args:
        points: (N, 3) read, in the camera's frame, metres.
        seed: of the search.

    Raises:
        ImitateError: no plane that could be a table.
    """
    if len(points) < _FEWEST:
        raise ImitateError(f"only {len(points)} pixels have a depth; a table cannot be found in them.")
    grid = _grid(points, COARSE)
    tables = [table for plane in _planes(grid, seed) if (table := _table(plane, grid)) is not None]
    if not tables:
        raise ImitateError(
            f"no table: no plane of {100 * SMALLEST:.0f} dm² or more in the {len(points)} readings."
        )
    tables.sort(key=lambda table: -table.inliers)
    carried = [_carried(table, tables[:k], grid) for k, table in enumerate(tables)]
    best = tables[int(np.argmax(carried))]
    return _table(best.plane, points) or best


def dense_parts(points: Array, apart: float, fewest: int) -> list[NDArray[np.intp]]:
    """Indices of the points (N, 3) of each part that is ``apart`` metres from the others, the largest first.

    Points with less than ``fewest`` neighbours, themselves included, are in none (DBSCAN, Ester et al. 1996).
    """
    o3d = open3d()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    labels = np.asarray(cloud.cluster_dbscan(apart, fewest))
    counts = np.bincount(labels[labels >= 0]) if (labels >= 0).any() else np.zeros(0, int)
    return [np.flatnonzero(labels == k) for k in np.argsort(-counts, kind="stable")]


def stands_on(table: Table, placed: Array) -> bool:
    """Whether this part of a view (N, 3), in the table's frame, is over the table and not furniture."""
    spread = placed.max(axis=0) - placed.min(axis=0)
    return bool(
        placed[:, 2].max() < 0.95 * ROOM
        and np.linalg.norm(spread[:2]) < LONGEST * np.sqrt(2)
        and table.reaches(placed).mean() > 0.5
    )


def _grid(points: Array, size: float) -> Array:
    o3d = open3d()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    return np.asarray(cloud.voxel_down_sample(size).points)


def _planes(points: Array, seed: int) -> list[Array]:
    """(4,) planes, the largest first, each found in what the ones before leave."""
    o3d = open3d()
    o3d.utility.random.seed(seed)
    rest, found = points, list[Array]()
    while len(found) < PLANES and len(rest) > max(SHARE * len(points), 3):
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(rest))
        gate = GATE * float(np.median(kinect_noise(rest[:, 2])))
        _, inliers = cloud.segment_plane(gate, 3, DRAWS)
        if len(inliers) < SHARE * len(points):
            break
        found.append(_plane_through(rest[inliers]))
        rest = np.delete(rest, inliers, axis=0)
    return found


def _table(plane: Array, points: Array) -> Table | None:
    """The table on about this plane, None where it does not hang together."""
    noise = 2.0
    for _ in range(3):
        near = _near(plane, points, noise)
        if near.sum() < 3:
            return None
        plane = _plane_through(points[near])
        noise = _scatter(plane, points[_near(plane, points, 2 * noise)])
    cells = _grid(points[near], 2 * COARSE)
    parts = dense_parts(cells, GAP, 4)
    if not parts or len(parts[0]) * (2 * COARSE) ** 2 < SMALLEST:
        return None
    top = cells[parts[0]]
    table = Table(plane, 0, *_frame(plane, top), noise)
    for _ in range(2):
        near = _near(plane, points, noise) & table.reaches(table.placed(points))
        plane = _plane_through(points[near])
    noise = _scatter(plane, points[near])
    return Table(plane, int(near.sum()), *_frame(plane, top), noise)


def _near(plane: Array, points: Array, noise: float) -> Mask:
    gate = GATE * noise * kinect_noise(points[:, 2]) * _steepness(points, plane[:3])
    return np.asarray(np.abs(points @ plane[:3] + plane[3]) < gate)


def _scatter(plane: Array, points: Array) -> float:
    along = (points @ plane[:3] + plane[3]) / _steepness(points, plane[:3])
    return scatter(along, points[:, 2])


def _steepness(points: Array, normal: Array) -> Array:
    """(N,) metres from a plane that a metre more of depth makes, along the rays to the points."""
    return np.asarray(np.maximum(np.abs(points @ normal) / points[:, 2], 0.05))


def _plane_through(points: Array) -> Array:
    """(4,) the least-squares plane, its normal towards the camera."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd((points - middle).T @ (points - middle))[0][:, 2]
    normal = normal if normal @ middle < 0 else -normal
    return np.append(normal, -normal @ middle)


def _frame(plane: Array, top: Array) -> tuple[Array, Array]:
    """table_from_camera (7,) and the outline (K, 2) of a tabletop's points, counter-clockwise."""
    normal, offset = plane[:3], plane[3]
    ahead = np.array([0, -1.0, 1.0])  # into the picture: forward where it looks along, up where it looks down
    x = ahead - normal * (normal @ ahead)
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(normal, x), normal], axis=1)
    local = top @ axes
    middle = local.min(axis=0) / 2 + local.max(axis=0) / 2
    middle[2] = -offset
    camera_from_table = np.concatenate([axes @ middle, Rotation.from_matrix(axes).as_quat()])
    hull = cv2.convexHull((local - middle)[:, :2].astype(np.float32))[:, 0].astype(float)
    turning = np.sum(hull[:, 0] * np.roll(hull[:, 1], -1) - hull[:, 1] * np.roll(hull[:, 0], -1))
    return inverse(camera_from_table), hull if turning > 0 else hull[::-1]


def _carried(table: Table, larger: list[Table], grid: Array) -> int:
    """How many points of a coarse grid belong to things that stand on the table, none of them a larger plane.

    Else a box's side would carry the table before it.
    """
    for other in larger:
        grid = grid[~(_near(other.plane, grid, other.scatter) & other.reaches(other.placed(grid)))]
    if not len(grid):
        return 0
    placed = table.placed(grid)
    above = placed[:, 2] > np.maximum(COARSE, 2 * GATE * table.height_noise(grid))
    placed = placed[above & (placed[:, 2] < ROOM)]
    touching = COARSE + 2 * GATE * float(np.median(table.height_noise(grid)))
    things = [placed[part] for part in dense_parts(placed, 2.5 * COARSE, 4)] if len(placed) else []
    return sum(len(t) for t in things if stands_on(table, t) and t[:, 2].min() < touching)
