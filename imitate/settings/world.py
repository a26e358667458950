"""Constants of the simulated world."""

from __future__ import annotations

from pydantic import Field, model_validator

from imitate.settings.section import Section


class World(Section):
    """The simulated robot and table."""

    robot: str = "panda"
    """name of a robot shipped with imitate, or the path of a robot's TOML file."""
    physics_rate: int = Field(default=240, ge=60, le=2000)
    """physics steps a second."""
    control_rate: int = Field(default=60, ge=10, le=1000)
    """control ticks a second; divides physics_rate."""
    settle_time: float = Field(default=0.5, ge=0, le=10)
    """s that each skill holds its last command before it is judged (ALGORITHMS 5)."""
    position_gain: float = Field(default=0.3, gt=0, le=1)
    """share of a joint's position error that its motor removes in one physics step."""
    solver_iterations: int = Field(default=50, ge=1, le=1000)
    """of the contact solver; a robot whose fingers need more has more."""
    object_density: float = Field(default=500.0, gt=0)
    """kg/m³: wood."""
    object_friction: float = Field(default=0.6, ge=0)
    """lateral coefficient; PyBullet multiplies those of the two bodies."""
    table_friction: float = Field(default=0.8, ge=0)
    """lateral coefficient."""
    spinning_friction: float = Field(default=0.001, ge=0)
    """m: a face's resistance to turning in the plane of contact."""
    reach_tolerance: float = Field(default=0.01, gt=0)
    """m between the hand and the pose asked for, beyond which the pose is out of reach."""
    reach_angle: float = Field(default=0.1, gt=0)
    """rad, likewise."""
    joint_margin: float = Field(default=0.1, ge=0)
    """rad that the arm keeps from its joints' limits over the whole demonstration."""
    reach_rate: float = Field(default=20.0, gt=0)
    """poses a second of the demonstration that are tried when the base is placed."""

    touch_tolerance: float = Field(default=0.01, ge=0)
    """m that two links of the arm, or one and the table, may overlap when the base is placed."""
    touch_interval: float = Field(default=0.5, gt=0)
    """s of the demonstration between the poses that are looked at for it."""

    @model_validator(mode="after")
    def _whole_ticks(self) -> World:
        if self.physics_rate % self.control_rate:
            raise ValueError("physics_rate must be a whole multiple of control_rate")
        return self
