"""The largest planes of a cloud, by RANSAC (Fischler & Bolles 1981), the same bits for the same seed.

Sums run point by point and no product is left to BLAS, whose last bits depend on how many threads share it.
"""

from __future__ import annotations

import numpy as np

from imitate.geometry import Array
from imitate.perception.shapes import Mask

DRAWS = 4000
"""planes through three points that are tried for each one found."""
SOME = 500
"""points that say which of them are worth a look at all points,"""
BEST = 20
"""and how many are."""
THIN = 1e-9
"""m², twice the area of a triangle that spans no plane."""


def planes(points: Array, gate: float, most: int, fewest: int, seed: int) -> list[Array]:
    """(4,) planes of points (N, 3), each found in what the ones before leave, the largest first.

    Args:
        gate: metres within which a point lies on a plane.
        most: planes.
        fewest: points on a plane.
        seed: of the draws.
    """
    generator = np.random.default_rng(seed)
    rest, found = points, list[Array]()
    while len(found) < most and len(rest) >= max(fewest, 3):
        plane = _largest(rest, gate, generator)
        on = np.abs(off_plane(plane, rest)) < gate
        if on.sum() < max(fewest, 3):
            break
        found.append(plane_through(rest[on]))
        rest = rest[~on]
    return found


def off_plane(plane: Array, points: Array) -> Array:
    """(N,) metres of points (N, 3) from a plane a b c d, on the side of its unit normal."""
    return np.asarray(np.einsum("nj,j->n", points, plane[:3]) + plane[3])


def plane_through(points: Array) -> Array:
    """(4,) the least-squares plane of points (N, 3), its normal towards the camera."""
    middle = points.mean(axis=0)
    normal = np.linalg.svd(np.einsum("ni,nj->ij", points - middle, points - middle))[0][:, 2]
    normal = normal if normal @ middle < 0 else -normal
    return np.append(normal, -normal @ middle)


def _largest(points: Array, gate: float, generator: np.random.Generator) -> Array:
    a, b, c = points[generator.integers(len(points), size=(3, DRAWS))]
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    spans = lengths > THIN
    normals = normals[spans] / lengths[spans, None]
    drawn = np.column_stack([normals, -np.sum(normals * a[spans], axis=1)])
    some = points[generator.permutation(len(points))[:SOME]]
    best = np.argsort(-_counts(drawn, some, gate), kind="stable")[:BEST]
    return np.asarray(drawn[best[np.argmax(_counts(drawn[best], points, gate))]])


def _counts(drawn: Array, points: Array, gate: float) -> Array:
    """(P,) how many of the points (N, 3) lie on each plane (P, 4)."""
    off = np.einsum("pj,nj->pn", drawn[:, :3], points) + drawn[:, 3:]
    on: Mask = np.abs(off) < gate
    return np.asarray(on.sum(axis=1))
