"""The initiation set I: from which starts an option is likely to succeed, learned from what was tried.

A kernel estimate with doubt: p(s) = Σ k(s, s_i) y_i / (Σ k(s, s_i) + doubt), where y_i is 1 for a success.
Where nothing was tried near by, the sums vanish and the doubt stays: an unknown place is not in I. Starts are
compared by their deviation from the mean start, decorrelated, so that a block out of its usual place *in the
hand* counts although hand and block together may begin in many places. The kernel's width is a share of the
median distance between starts: the least with which the others foretell as many of the starts as they can.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.demonstration import HAND, TABLE
from imitate.geometry import IDENTITY, Array, conjugate, quaternion_multiply, relative
from imitate.record import TrialRecord
from imitate.settings import Learning
from imitate.skill import Abstraction, InitiationSet

_SHARES = (0.25, 0.35, 0.5, 0.7, 1.0)
"""of the median distance, tried for the kernel's width."""


def start_of(
    record: TrialRecord, object_names: Sequence[str], abstraction: Abstraction, option: int = -1
) -> Array:
    """Poses (B, 7) of the relevant bodies in the reference's frame when an option of a trial starts."""
    step = max(record.option_starts[option] - 1, 0)
    bodies = np.vstack([record.hand_poses[step][None], record.object_poses[step]])
    return seen_from(abstraction, object_names, bodies)


def seen_from(abstraction: Abstraction, object_names: Sequence[str], bodies: Array) -> Array:
    """Poses (B, 7) of the relevant bodies in the reference's frame, from those of all bodies in the world.

    Args:
        bodies: (K + 1, 7), the hand and then the objects.
    """
    world = dict(zip((HAND, *object_names), bodies, strict=True)) | {TABLE: IDENTITY}
    relevant = np.array([world[body] for body in abstraction.relevant])
    return relative(world[abstraction.reference], relevant)


def initiation_set(
    abstraction: Abstraction, starts: Array, succeeded: Array, settings: Learning
) -> InitiationSet:
    """I from the starts tried, and how well each is foretold by the others.

    Args:
        abstraction: the starts are its relevant bodies' poses in its reference's frame.
        starts: (n, B, 7), n ≥ 1.
        succeeded: (n,) 1 where β held at the end, else 0.
        settings: of learning.
    """
    everything = _fitted(abstraction, starts, succeeded, settings)
    n = len(starts)
    foretold = np.zeros(n)
    for i in range(n if n > 1 else 0):
        others = np.arange(n) != i
        foretold[i] = probability(
            _fitted(abstraction, starts[others], succeeded[others], settings), starts[i]
        )
    return InitiationSet(**{**vars(everything), "foretold": foretold})


def probability(initiation: InitiationSet, start: Array) -> float:
    """p that the option succeeds from poses (B, 7) of its bodies in the reference's frame."""
    tried = _features(initiation.mean, initiation.starts) @ initiation.decorrelation.T
    here = _features(initiation.mean, start[None]) @ initiation.decorrelation.T
    near = _kernel(np.linalg.norm(tried - here, axis=1), initiation.width)
    return float(near @ initiation.succeeded / (near.sum() + initiation.doubt))


def _fitted(abstraction: Abstraction, starts: Array, succeeded: Array, settings: Learning) -> InitiationSet:
    # What is less than rest, a tenth of the tolerance, is no difference between starts.
    rest = [settings.near / 10] * 3 + [np.deg2rad(settings.near_angle) / 10] * 3
    mean = np.concatenate(
        [
            starts[..., :3].mean(axis=0),
            np.array([_mean_turn(turns) for turns in starts[..., 3:].swapaxes(0, 1)]),
        ],
        axis=1,
    )
    features = _features(mean, starts)
    spread = features.T @ features / len(features) + np.diag(np.tile(rest, starts.shape[1]) ** 2)
    decorrelation = np.linalg.inv(np.linalg.cholesky(spread))
    there = features @ decorrelation.T
    distances = np.linalg.norm(there[:, None] - there[None], axis=-1)
    width = _width(distances, succeeded, settings)
    return InitiationSet(
        bodies=abstraction.relevant,
        reference=abstraction.reference,
        starts=starts,
        succeeded=succeeded,
        foretold=np.zeros(0),
        mean=mean,
        decorrelation=decorrelation,
        width=width,
        doubt=settings.initiation_doubt,
        threshold=settings.initiation_threshold,
    )


def _width(distances: Array, succeeded: Array, settings: Learning) -> float:
    pairs = distances[np.triu_indices(len(distances), 1)]
    median = max(float(np.median(pairs)), 1.0) if len(pairs) else 1.0

    def wrong(share: float) -> int:
        near = _kernel(distances, share * median) * (1 - np.eye(len(distances)))
        p = near @ succeeded / (near.sum(axis=1) + settings.initiation_doubt)
        return int(np.sum((p >= settings.initiation_threshold) != (succeeded > 0)))

    return min(_SHARES, key=wrong) * median


def _kernel(distances: Array, width: float) -> Array:
    return np.asarray(np.exp(-((distances / width) ** 2) / 2))


def _features(mean: Array, starts: Array) -> Array:
    # (n, 6B): m, then the rotation vector (rad) from the mean, for each body.
    position = starts[..., :3] - mean[:, :3]
    turned = quaternion_multiply(conjugate(mean[:, 3:]), starts[..., 3:])
    vectors = Rotation.from_quat(turned.reshape(-1, 4)).as_rotvec().reshape(position.shape)
    return np.concatenate([position, vectors], axis=-1).reshape(len(starts), -1)


def _mean_turn(turns: Array) -> Array:
    return np.asarray(Rotation.from_quat(turns).mean().as_quat())
