"""All settings together, and the sets that the modes begin from."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from imitate.settings.learning import Learning
from imitate.settings.perception import Perception
from imitate.settings.policy import PolicySettings
from imitate.settings.section import Section
from imitate.settings.segmentation import Mode, Segmentation
from imitate.settings.world import World


class Settings(Section):
    """All of them."""

    mode: Mode = "robust"
    perception: Perception = Perception()
    segmentation: Segmentation = Segmentation()
    policy: PolicySettings = PolicySettings()
    learning: Learning = Learning()
    world: World = World()

    @model_validator(mode="after")
    def _force_is_private(self) -> Settings:
        if self.mode == "faithful" and self.learning.gripper_from_opening:
            raise ValueError(
                "learning.gripper_from_opening is true, and in the faithful mode the gripper's force is to "
                "be discovered; leave it out, or use the robust mode"
            )
        return self


_FAITHFUL: dict[str, dict[str, Any]] = {
    "segmentation": {"mode": "faithful", "shortest": 0.0, "rest_limit": 0.0},
    "learning": {
        "imitation_first": False,
        "exploration": "per-kernel",
        "candidates": 0,
        "curtail": False,
        "more_updates": 0,
        "keep_failed": True,
        "keep_carried": False,
        "improve_by": "total",
        "judge": "cost",
        "free_hand": False,
        "correct_goals": False,
        "closed_end_cost": 0.0,
        "gripper_noise": 60.0,
        "gripper_smoothness": 0.0,
        "gripper_from_opening": False,
        "wait_to_close": False,
        "hold_in_air": False,
    },
    "policy": {"gripper_decay": 2.0, "orientation": "quaternion"},
}


_CST: dict[str, dict[str, Any]] = {"segmentation": {"mode": "cst", "shortest": 0.0, "rest_limit": 0.0}}

OF_MODE = {"faithful": _FAITHFUL, "cst": _CST}
"""mode → what differs from the robust one's values."""
