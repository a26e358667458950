"""A body at rest: measurements of it are averaged until it moves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, conjugate, quaternion_multiply

STILL, TURNED = 0.0015, 0.03
"""m and rad between a measurement and where a body rests, above which it has moved."""
CREPT = 0.0006
"""m, the same of a running mean of measurements, so that slow movements count too."""
MEMORY = 0.7
"""share of the running mean that each frame keeps."""
LONG = 40
"""measurements that are averaged at most."""


@dataclass
class Rest:
    """How long a body has rested, in frames, and how far its measurements have been off of late, metres."""

    frames: int = 0
    crept: Array = field(default_factory=lambda: np.zeros(3))

    def settled(self, pose: Array, measured: Array) -> Array:
        """(7,) where a body is that was thought to be at ``pose`` and is now measured elsewhere."""
        apart = measured[:3] - pose[:3]
        turn = Rotation.from_quat(quaternion_multiply(measured[3:], conjugate(pose[3:])))
        self.crept = MEMORY * self.crept + (1 - MEMORY) * apart
        far = np.linalg.norm(apart) > STILL or turn.magnitude() > TURNED
        if far or np.linalg.norm(self.crept) > CREPT:
            self.frames, self.crept = 0, np.zeros(3)
            return measured
        self.frames += 1
        gain = 1 / (1 + min(self.frames, LONG))
        nearer = Rotation.from_rotvec(gain * turn.as_rotvec()).as_quat()
        return np.concatenate([pose[:3] + gain * apart, quaternion_multiply(nearer, pose[3:])])
