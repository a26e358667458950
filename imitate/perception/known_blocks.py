"""Following blocks whose sizes and paints are known, before a camera whose place is known.

So a robot watches its own trials: nothing is left to find but where each block is, and Open3D is not needed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imitate.geometry import Array, rotate
from imitate.perception.block import Block
from imitate.perception.eye import Eye, View
from imitate.perception.tracker import BlockTracker, Motion
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception

AROUND = 0.6
"""m to each side of where the blocks are expected, in which the table is searched for one not seen."""


class KnownBlocks:
    """Trackers of K blocks that know them before they see them.

    Args:
        intrinsics: of every frame.
        world_from_camera: (7,) the camera's pose; z = 0 on the table.
        hues: K, what each block is painted, each in a hue of its own.
        sizes: (K, 3) metres.
        expected: (K, 7) where each was before the first frame; with ``sought`` only what it looked like: of
            the poses that look the same, the one turned least from this is meant.
        settings: the sensor's noise, the filter's effort.
        seed: of every random draw.
        sought: whether they are looked for over the whole table first.
    """

    def __init__(
        self,
        intrinsics: Intrinsics,
        world_from_camera: Array,
        hues: Sequence[str],
        sizes: Array,
        expected: Array,
        settings: Perception,
        seed: np.random.SeedSequence,
        sought: bool = True,
    ) -> None:
        rays = rotate(world_from_camera[3:], intrinsics.rays()).astype(np.float32)
        low, high = expected[:, :2].min(axis=0) - AROUND, expected[:, :2].max(axis=0) + AROUND
        self._eye = Eye(intrinsics, world_from_camera, rays, low, high, None)
        self._blocks = [
            BlockTracker(Block(size, pose), hue, np.zeros((0, 3)), settings, sought)
            for hue, size, pose in zip(hues, sizes, expected, strict=True)
        ]
        self._generators = [np.random.default_rng(child) for child in seed.spawn(len(self._blocks))]
        self._last: list[Array | None] = [None if sought else pose for pose in expected]
        self._frames = 0

    def follow(self, frame: RgbdFrame, hand: Motion | None) -> Array:
        """(K, 7) world poses in this frame; seven NaN where a block is not seen.

        One that was seen, and where it was last seen is now wholly hidden, as by a hand around it, is still
        there: a block whose place is in view and empty is not.

        Args:
            frame: the next one.
            hand: how the robot's hand moved since the frame before, by its joints; None in the first.
        """
        view, self._frames = View(self._eye, frame, self._frames), self._frames + 1
        sights = [
            block.follow(view, self._blocks, hand, generator)
            for block, generator in zip(self._blocks, self._generators, strict=True)
        ]
        for block in self._blocks:
            block.lie(self._blocks)
        for k, (block, sight) in enumerate(zip(self._blocks, sights, strict=True)):
            last = self._last[k]
            if sight.pose is not None:
                self._last[k] = sight.pose
            elif last is not None and not block.is_covered_at(view, self._blocks, last):
                self._last[k] = None
        return np.array([np.full(7, np.nan) if pose is None else pose for pose in self._last])
