"""The table in a view: of several planes, the one that carries things."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from imitate.errors import ImitateError
from imitate.geometry import Array, inverse, read_only, rotate
from imitate.perception.clusters import dense_parts, thinned
from imitate.perception.noise import kinect_noise, scatter
from imitate.perception.planes import off_plane, plane_through, planes
from imitate.perception.shapes import Mask

PLANES = 6
"""planes that are looked at, the largest first."""
SHARE = 0.01
"""of a view's surface that a plane must hold to be looked at."""
SOLID = 0.05
"""points that are seen through a tabletop, as a share of those on it, up to which it is one."""
SMALLEST = 0.02
"""m² of a tabletop that are seen, at least."""
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
        doubt: why it may be none, in words; empty where nothing speaks against it.
    """

    plane: Array
    inliers: int
    table_from_camera: Array
    outline: Array
    scatter: float
    doubt: str = ""

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

    def reaches(self, placed: Array, beside: float = BESIDE) -> Mask:
        """(N,) which points (N, 3) of the table's frame are over it, or ``beside`` metres beside it."""
        edges = np.roll(self.outline, -1, axis=0) - self.outline
        outwards = np.stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)
        beyond = placed[:, :2] @ outwards - np.einsum("kj,jk->k", self.outline, outwards)
        return np.asarray(beyond.max(axis=1) < beside)


def find_table(points: Array, seed: int) -> Table:
    """The plane that carries most; where none carries anything, the largest.

    Several planes are found by RANSAC (the paper, Appendix A, takes the largest). A plane carries the
    compact things that stand on it within its outline: a table's objects, but not a table on a floor. One
    that cuts through things carries their upper halves, but is seen through.

    Args:
        points: (N, 3) read, in the camera's frame, metres.
        seed: of the search.

    Raises:
        ImitateError: no plane that could be a table.
    """
    if len(points) < _FEWEST:
        raise ImitateError(f"only {len(points)} pixels have a depth; a table cannot be found in them.")
    grid = thinned(points, COARSE)
    gate = GATE * float(np.median(kinect_noise(grid[:, 2])))
    found = planes(grid, gate, PLANES, int(SHARE * len(grid)), seed)
    tables = [table for plane in found if (table := _table(plane, grid)) is not None]
    if not tables:
        raise ImitateError(
            f"no table: no plane of {100 * SMALLEST:.0f} dm² or more in the {len(points)} readings."
        )
    tables.sort(key=lambda table: -table.inliers)
    sensor = min(table.scatter for table in tables)
    through = [max(_seen_through(table, grid, sensor), SOLID) for table in tables]
    carried = [_carried(table, tables[:k], grid) for k, table in enumerate(tables)]
    solid = [table for table, share in zip(tables, through, strict=True) if share <= SOLID]
    tops = [sum(top.inliers for top in solid if _is_on(top, table)) for table in tables]
    merits = [(-share, on + top) for share, on, top in zip(through, carried, tops, strict=True)]
    k = max(range(len(tables)), key=merits.__getitem__)
    table = _table(tables[k].plane, points) or tables[k]
    if through[k] <= SOLID:
        return table
    doubt = f"it cuts through things: as much is seen through it as {through[k]:.0%} of what lies on it"
    return replace(table, doubt=doubt)


def stands_on(table: Table, placed: Array, beside: float = BESIDE) -> bool:
    """Whether this part of a view (N, 3), in the table's frame, is over the table and no furniture."""
    spread = placed.max(axis=0) - placed.min(axis=0)
    return bool(
        placed[:, 2].max() < 0.95 * ROOM
        and np.linalg.norm(spread[:2]) < LONGEST * np.sqrt(2)
        and table.reaches(placed, beside).mean() > 0.5
    )


def _table(plane: Array, points: Array) -> Table | None:
    """The table on about this plane, None where it does not hang together."""
    noise = 2.0
    for _ in range(3):
        near = _near(plane, points, noise)
        if near.sum() < 3:
            return None
        plane = plane_through(points[near])
        noise = _scatter(plane, points[_near(plane, points, 2 * noise)])
    cells = thinned(points[near], 2 * COARSE)
    parts = dense_parts(cells, GAP, 4)
    if not parts or len(parts[0]) * (2 * COARSE) ** 2 < SMALLEST:
        return None
    top = cells[parts[0]]
    table = Table(plane, 0, *_frame(plane, top), noise)
    for _ in range(2):
        near = _near(plane, points, noise) & table.reaches(table.placed(points))
        plane = plane_through(points[near])
    noise = _scatter(plane, points[near])
    return Table(plane, int(near.sum()), *_frame(plane, top), noise)


def _near(plane: Array, points: Array, noise: float) -> Mask:
    gate = GATE * noise * kinect_noise(points[:, 2]) * _steepness(points, plane[:3])
    return np.asarray(np.abs(off_plane(plane, points)) < gate)


def _scatter(plane: Array, points: Array) -> float:
    along = off_plane(plane, points) / _steepness(points, plane[:3])
    return scatter(along, points[:, 2])


def _steepness(points: Array, normal: Array) -> Array:
    """(N,) metres from a plane that a metre more of depth makes, along the rays to the points."""
    return np.asarray(np.maximum(np.abs(np.einsum("nj,j->n", points, normal)) / points[:, 2], 0.05))


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
    touching = 2 * COARSE + 2 * GATE * float(np.median(table.height_noise(grid)))  # a cell's mean is in it
    things = [placed[part] for part in dense_parts(placed, 2.5 * COARSE, 4)] if len(placed) else []
    return sum(len(t) for t in things if stands_on(table, t) and t[:, 2].min() < touching)


def _is_on(top: Table, table: Table) -> bool:
    """Whether one plane is the top or a side of a thing on the other, which may be hidden by more things."""
    flat = np.pad(top.outline, ((0, 0), (0, 1)))
    camera_from_top = inverse(top.table_from_camera)
    corners = table.placed(camera_from_top[:3] + rotate(camera_from_top[3:], flat))
    return bool(np.median(corners[:, 2]) > 2 * COARSE) and stands_on(table, corners, LONGEST)


def _seen_through(table: Table, grid: Array, sensor: float) -> float:
    """Points of a coarse grid that lie behind the tabletop, as a share of those on it.

    Args:
        sensor: its noise, as a multiple of a Kinect's; a plane through things makes them look like noise.
    """
    placed, origin = table.placed(grid), table.table_from_camera[:3]
    noise = sensor * kinect_noise(grid[:, 2]) * _steepness(grid, table.plane[:3])
    behind = placed[placed[:, 2] < -np.maximum(COARSE, 2 * GATE * noise)]
    on_the_way = origin + (origin[2] / (origin[2] - behind[:, 2]))[:, None] * (behind - origin)
    return float(table.reaches(on_the_way, -COARSE).sum() / table.inliers)
