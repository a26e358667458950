"""What speaks against a fitted block, and how far each of its faces is known."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, compose
from imitate.perception.block import Block
from imitate.perception.shapes import Mask, Pixels, agreement, box_depth

STRAIN = 0.025
"""mean of how many tolerances a thing's points lie beyond the tolerance, at most one each, from which a block
does not account for them: up to 0.018 in a Kinect's views of single boxes, mostly over 0.035 where small
ones touch."""
THROUGH = 0.5
"""of a tolerance, what a pixel that sees through the block counts for."""
STEPS = np.array([0.0005, 0.001, 0.002, 0.004, 0.008, 0.016, 0.032, 0.064])
"""m by which a face is moved to see whether that contradicts what was seen."""
EDGE = 1.5 / 525
"""rad, standard deviation of where a Kinect sees a depth's edge: a third of its 9-pixel matching window."""
DROP = 0.5
"""log-likelihood that one standard deviation costs."""
_FACES = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])


def off_faces(block: Block, points: Array) -> Array:
    """(N,) distance in metres of points (N, 3) from the block's surface; negative inside it."""
    turned = Rotation.from_quat(block.pose[3:]).inv().apply(points - block.pose[:3])
    beyond = np.abs(turned) - block.size / 2
    outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
    return np.asarray(outside + np.minimum(beyond.max(axis=1), 0))


def doubt(block: Block, pixels: Pixels, own: Mask, tolerance: float) -> str:
    """Why one block does not account for what was seen, in words; empty where it does.

    Args:
        block: fitted to them.
        pixels: of the block and around it.
        own: (M,) which of them show the thing.
        tolerance: metres, what noise and the pixels' width explain.
    """
    through = seen_through(block, pixels, own, tolerance)
    strain = strained(block, pixels.points()[own], tolerance)
    if strain + THROUGH * through < STRAIN:
        return ""
    if strain < THROUGH * through:
        return f"the table or something else is seen where one block would be, in {through:.0%} of its pixels"
    outside = np.mean(np.abs(off_faces(block, pixels.points()[own])) > tolerance)
    return f"{outside:.0%} of its points lie off the faces of one block"


def strained(block: Block, points: Array, tolerance: float) -> float:
    """0…1, the mean of how many tolerances points (N, 3) lie beyond the tolerance of the block's surface."""
    return float(np.mean(np.clip(np.abs(off_faces(block, points)) / tolerance - 1, 0, 1)))


def seen_through(block: Block, pixels: Pixels, own: Mask, tolerance: float) -> float:
    """Pixels that look through the block, by more than the tolerance, as a share of its own."""
    core = np.maximum(block.size - 2 * tolerance, 0.001)
    entered = box_depth(pixels, block.pose[None], core)[0]
    through = ~own & (pixels.depth > entered + tolerance)
    return float(through.sum() / max(own.sum(), 1))


def size_deviation(block: Block, pixels: Pixels, own: Mask, noise: float, edge: float) -> Array:
    """(3,) standard deviation of the block's size: how far its faces can move before that is contradicted.

    A face whose end is hidden, by another thing or by the picture's edge, can move far. Errors that
    neighbours share are not in the likelihood: no face is known better than its depth, where it faces the
    camera, or than its edge in the picture.

    Args:
        block: fitted to them.
        pixels: of the block and around it.
        own: (M,) which of them show the thing.
        noise: standard deviation of their depth, metres.
        edge: standard deviation of where its edges are seen, metres.
    """
    best = _scores(block, _FACES[0], np.zeros(1), pixels, own, noise)[0]
    variance = np.zeros(3)
    for face in _FACES:
        outwards = _reach(best - _scores(block, face, STEPS, pixels, own, noise))
        inwards = _reach(best - _scores(block, face, -STEPS, pixels, own, noise))
        shared = _shared(block, face, pixels.origin, noise, edge)
        variance += np.abs(face) * (max(outwards, inwards) ** 2 + shared**2)
    return np.asarray(np.sqrt(variance))


def _shared(block: Block, face: Array, origin: Array, noise: float, edge: float) -> float:
    """Standard deviation in metres of where a face lies that no number of pixels makes smaller."""
    outwards = Rotation.from_quat(block.pose[3:]).apply(face)
    sight = block.pose[:3] - origin
    towards = -float(outwards @ sight / np.linalg.norm(sight))
    by_edge = edge / max(np.sqrt(1 - towards**2), 0.1)
    return float(min(noise / towards, by_edge) if towards > 0 else by_edge)


def _scores(block: Block, face: Array, steps: Array, pixels: Pixels, own: Mask, noise: float) -> Array:
    """(K,) log-likelihoods with one face moved outwards by steps (K,), the opposite one staying."""
    sizes = np.maximum(block.size + np.abs(face) * steps[:, None], 0.002)
    shifts = np.tile([0, 0, 0, 0, 0, 0, 1.0], (len(steps), 1))
    shifts[:, :3] = face * steps[:, None] / 2
    depth = box_depth(pixels, compose(block.pose, shifts), sizes)
    return np.asarray(agreement(pixels, own, depth, noise), float)


def _reach(drops: Array) -> float:
    """The first step whose drop is more than one standard deviation's; the longest where none is."""
    contradicted = np.flatnonzero(drops > DROP)
    return float(STEPS[contradicted[0]] if len(contradicted) else STEPS[-1])
