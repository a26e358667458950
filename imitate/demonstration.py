"""Demonstration: what was observed, and what makes one valid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imitate.errors import DemonstrationError
from imitate.geometry import NEARLY, Array, align_signs, nearly_normalised, read_only, resample

HAND = "hand"
TABLE = "table"
"""the demonstration's own frame, as a reference where no object is left to be one."""
FAR = 1e8
"""m, beyond anything on earth: such a number is damage, and its square may not be one any more."""
LONGEST_GAP = 60.0
"""s from a frame to the next: beyond, nothing is known of the motion, and nobody waits for it."""
LONGEST = 3600.0
"""s from the first frame to the last: whatever goes through time in even steps stays bounded."""


@dataclass(frozen=True)
class Demonstration:
    """Pose trajectories of the hand and the objects.

    The hand's pose is its tool-centre point: between the fingertips, y along the opening of the fingers, z
    towards the fingertips. Where a body was not seen, its pose is seven NaN.

    Attributes:
        t: (T,) seconds, strictly increasing, in steps of `LONGEST_GAP` at most that need not be equal, up to
            `LONGEST` in all.
        hand: (T, 7) poses in the demonstration's frame, z up; quaternions off length one by less than 1 %
            are scaled to it.
        objects: (T, K, 7) poses in the same frame.
        object_names: K distinct names, none of them "hand" or "table".
        object_sizes: (K, 3) metres along each object's x, y, z; NaN where not known.
        opening: (T,) metres between the fingertips' inner surfaces, NaN where not seen; None where they never
            were.

    Raises:
        DemonstrationError: when a field breaks one of these.
    """

    t: Array
    hand: Array
    objects: Array
    object_names: tuple[str, ...]
    object_sizes: Array
    opening: Array | None = None

    def __post_init__(self) -> None:
        for field in ("t", "hand", "objects", "object_sizes"):
            object.__setattr__(self, field, read_only(getattr(self, field)))
        if self.opening is not None:
            object.__setattr__(self, "opening", read_only(self.opening))
        object.__setattr__(self, "object_names", tuple(str(name) for name in self.object_names))
        _check_shapes(self)
        for field in ("hand", "objects"):
            object.__setattr__(self, field, read_only(nearly_normalised(getattr(self, field))))
        _check_times(self.t)
        _check_poses("hand", self.hand)
        for k, name in enumerate(self.object_names):
            _check_poses(f"objects[:, {k}] ({name})", self.objects[:, k])

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return float(self.t[-1] - self.t[0])

    def pose_of(self, name: str) -> Array:
        """The trajectory (T, 7) of the hand, an object or the table, by name; the table is where it is."""
        if name == TABLE:
            return np.tile([0.0, 0, 0, 0, 0, 0, 1], (len(self.t), 1))
        return self.hand if name == HAND else self.objects[:, self.object_names.index(name)]

    def seen(self, name: str) -> NDArray[np.bool_]:
        """(T,) whether the hand or an object was seen, by name."""
        return np.asarray(~np.isnan(self.pose_of(name)[:, 0]))

    def size_of(self, name: str) -> Array:
        """The size (3,) of an object in metres."""
        return np.asarray(self.object_sizes[self.object_names.index(name)])


def table_height(demonstration: Demonstration) -> float:
    """Height of the table in the demonstration's frame: where the lowest object first stands.

    Raises:
        DemonstrationError: when no object's height is known.
    """
    first = demonstration.objects[
        [int(np.argmax(demonstration.seen(name))) for name in demonstration.object_names],
        np.arange(len(demonstration.object_names)),
    ]
    heights = first[:, 2] - demonstration.object_sizes[:, 2] / 2
    if np.all(np.isnan(heights)):
        raise DemonstrationError(
            "object_sizes: no object's size is known, so the table's height is not either. "
            "Give object_sizes (K, 3) in metres for at least one object."
        )
    return float(np.nanmin(heights))


def in_table_frame(demonstration: Demonstration) -> Demonstration:
    """The demonstration with t = 0 at its first frame and z = 0 on the table."""
    down = np.array([0, 0, table_height(demonstration), 0, 0, 0, 0])
    return replace(
        demonstration,
        t=demonstration.t - demonstration.t[0],
        hand=demonstration.hand - down,
        objects=demonstration.objects - down,
    )


def interpolated(demonstration: Demonstration) -> Demonstration:
    """The demonstration with every pose that was not seen filled in between its neighbours in time."""
    d = demonstration
    if not (np.isnan(d.hand).any() or np.isnan(d.objects).any()):
        return d

    def filled(name: str) -> Array:
        seen = d.seen(name)
        return align_signs(resample(d.t[seen], d.pose_of(name)[seen], d.t))

    objects = np.stack([filled(name) for name in d.object_names], axis=1)
    return replace(d, hand=filled(HAND), objects=objects)


def _check_shapes(d: Demonstration) -> None:
    frames, count = d.t.shape[0] if d.t.ndim else 0, len(d.object_names)
    if d.t.ndim != 1 or frames < 2:
        raise DemonstrationError(f"t: shape {d.t.shape}; expected (T,) with at least 2 frames.")
    if not count:
        raise DemonstrationError("object_names: empty; expected at least one object.")
    if len(set(d.object_names)) < count or {HAND, TABLE} & set(d.object_names):
        raise DemonstrationError(
            f"object_names: {', '.join(d.object_names)}; expected distinct names, none of them 'hand' or "
            "'table'."
        )
    expected = {"hand": (frames, 7), "objects": (frames, count, 7), "object_sizes": (count, 3)}
    expected |= {"opening": (frames,)} if d.opening is not None else {}
    for field, shape in expected.items():
        got = getattr(d, field).shape
        if got != shape:
            raise DemonstrationError(
                f"{field}: shape {got}; expected {shape} for {frames} frames and {count} objects."
            )
    sizes = d.object_sizes[~np.isnan(d.object_sizes)]
    if np.any(sizes <= 0) or np.any(np.isinf(sizes)):
        raise DemonstrationError("object_sizes: not positive; expected metres, NaN where not known.")
    if d.opening is not None and np.any((d.opening < 0) | np.isinf(d.opening)):
        k = int(np.argmax((d.opening < 0) | np.isinf(d.opening)))
        raise DemonstrationError(
            f"opening: {d.opening[k]:.4g} m at frame {k}; expected metres between the fingertips, 0 when "
            "they touch, NaN where not seen."
        )


def _check_times(t: Array) -> None:
    if not np.all(np.isfinite(t)):
        bad = ~np.isfinite(t)
        raise DemonstrationError(
            f"t: not a number at frame {int(np.argmax(bad))}, {int(bad.sum())} frames in all; expected "
            "seconds. Leave those frames out."
        )
    steps = np.diff(t)
    if np.any(steps <= 0):
        k = int(np.argmax(steps <= 0))
        raise DemonstrationError(
            f"t: goes from {t[k]:.6g} s to {t[k + 1]:.6g} s at frame {k + 1}; expected strictly increasing "
            "times. " + ("Remove repeated frames." if t[k] == t[k + 1] else "Sort the frames.")
        )
    if steps.max() > LONGEST_GAP:
        k = int(np.argmax(steps))
        raise DemonstrationError(
            f"t: {span_in_words(steps[k])} pass without a frame, from {t[k] - t[0]:.6g} s after the first "
            f"(frame {k}); expected {LONGEST_GAP:g} s at most. Keep what lies before or after."
        )
    if t[-1] - t[0] > LONGEST:
        raise DemonstrationError(
            f"t: lasts {span_in_words(t[-1] - t[0])}; expected {span_in_words(LONGEST)} at most. Keep the "
            "part that shows the task."
        )


def span_in_words(seconds: float) -> str:
    """A span of time in the largest unit of which there are two: "95 s", "26 hours", "19,676 days"."""
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2 * length:
            count = seconds / length
            return f"{count:,.0f} {unit}" if count >= 100 else f"{count:.3g} {unit}"
    return f"{seconds:.4g} s"


def _check_poses(name: str, poses: Array) -> None:
    missing = np.isnan(poses).all(axis=1)
    finite = np.isfinite(poses).all(axis=1)
    if not (finite | missing).all():
        bad = ~(finite | missing)
        raise DemonstrationError(
            f"{name}: NaN or infinite at frame {int(np.argmax(bad))}, {int(bad.sum())} frames in all; "
            "expected x y z qx qy qz qw, or seven NaN where it was not seen."
        )
    if finite.sum() < 2:
        raise DemonstrationError(f"{name}: seen in {int(finite.sum())} frames; expected at least 2.")
    far = np.nan_to_num(np.abs(poses)).max(axis=1)
    if far.max() > FAR:
        k = int(np.argmax(far))
        raise DemonstrationError(
            f"{name}: {far[k]:.4g} at frame {k}; expected metres and a unit quaternion, x y z qx qy qz qw."
        )
    norms = np.where(missing, 1, np.linalg.norm(poses[:, 3:], axis=1))
    off = np.abs(norms - 1) >= NEARLY
    if off.any():
        k = int(np.argmax(off))
        raise DemonstrationError(
            f"{name}: quaternion of length {norms[k]:.4g} at frame {k}; expected unit quaternions in the "
            "order qx qy qz qw."
        )
