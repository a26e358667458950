"""Constants of movements."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from imitate.settings.section import Section


class PolicySettings(Section):
    """How a movement is written down (the paper, section 5.2 and Appendix B)."""

    pose_kernels: int = Field(default=30, ge=2, le=500)
    """forcing-term kernels of each of the pose's channels."""
    form: Literal["hoffmann", "original"] = "hoffmann"
    """Hoffmann's form of the primitives, or Schaal's original one (the paper, Appendix B)."""
    orientation: Literal["quaternion", "log"] = "log"
    """orientation's channels: the quaternion's four (the paper), or three of its logarithm (Ude 2014)."""
    phase_decay: float = Field(default=4.6, gt=0, le=20)
    """the phase ends at exp(−phase_decay): 0.01."""
    stiffness: float = Field(default=50.0, gt=4, le=500)
    """α of the pose DMP, per duration; β = α/4."""
    gripper_kernels: int = Field(default=5, ge=2, le=100)
    gripper_decay: float = Field(default=0.0, ge=0, le=20)
    """phase decay of the gripper DMP, whose goal is no force; 0: phase and force fall evenly."""
    gripper_stiffness: float = Field(default=50.0, gt=4, le=500)
    """α of the gripper DMP, per duration."""
    open_below: float = Field(default=2.0, ge=0)
    """N below which the gripper's force counts as open."""
