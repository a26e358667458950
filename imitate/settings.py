"""Every constant of the method, typed, with unit and source; TOML in and out.

Two complete sets exist: ``robust`` (the default, for users) and ``faithful`` (as the paper states it, for the
tables). ``cst`` is ``robust`` but for the segmentation, which is the baseline that the paper compares with. A
settings file holds ``mode`` and whatever is to differ from that mode's values.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from imitate.errors import FileError, UnknownNameError, UsageError

Mode = Literal["robust", "faithful", "cst"]


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Perception(_Section):
    """RGB-D frames → demonstration (the paper, Appendix A)."""

    colour_topic: str = ""
    """of a recording in MCAP; found by type and content where empty, as are the next two."""
    depth_topic: str = ""
    calibration_topic: str = ""
    """of the colour camera; the depth camera's too where their pictures have one frame."""
    intrinsics: tuple[float, ...] = ()
    """fx, fy, cx, cy in pixels, then any distortion k1, k2, p1, p2, k3: instead of a recording's own."""
    depth_unit: float = Field(0.0, ge=0, le=1)
    """m of one step of a depth, or of 1.0 where it is a float; 0: as the format says (ROS: REP 118)."""
    colour_from_depth: tuple[float, ...] = ()
    """x y z qx qy qz qw, m: the depth camera in the colour camera's frame, instead of a recording's own."""
    pair_within: float = Field(0.04, gt=0, le=1)
    """s, the most between the colour and the depth of one frame: a period at 25 Hz."""
    salvage: bool = False
    """use a damaged recording as far as it can be read."""
    hand_offset: float = Field(default=0.0, ge=-0.5, le=0.5)
    """m along the hand's −z: 0.1 puts the origin where the paper has it; undone in the demonstration."""
    left_finger: str = "red"
    """colour of the left finger: a hue's name, "#c81e1e", or "U,V", a pixel of the first picture."""
    right_finger: str = "yellow"
    """colour of the right finger, likewise; the hand's y points from left to right."""
    finger_radius: float = Field(0.009, gt=0, le=0.05)
    """m, of the cylinder worn on a finger: measured once on the glove, not seen."""
    finger_length: float = Field(0.08, gt=0, le=0.3)
    """m, of the cylinder, from its far end to the fingertip: measured once on the glove, not seen."""
    depth_noise: float = Field(0.003, gt=0, le=0.05)
    """m, standard deviation of a depth reading: twice a Kinect's axial noise below 1 m."""
    still_frames: int = Field(8, ge=1, le=300)
    """first frames whose median is searched for table and blocks; nothing but the hand may move in them."""
    particles: int = Field(160, ge=20)
    """of the filter that follows one object, or the hand."""
    layers: int = Field(6, ge=2, le=20)
    """times that the particles are weighted and drawn again in each frame."""
    pixels: int = Field(700, ge=100)
    """of a frame that are compared with one object, or one finger, at most."""

    @field_validator("intrinsics", "colour_from_depth")
    @classmethod
    def _all_numbers(cls, given: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        counts = {"intrinsics": (0, 4, 8, 9), "colour_from_depth": (0, 7)}[info.field_name or ""]
        if len(given) not in counts:
            raise ValueError(f"expected {' or '.join(map(str, counts[1:]))} numbers, got {len(given)}")
        return given


class Segmentation(_Section):
    """Demonstration → segments (the paper, section 4; ALGORITHMS 2)."""

    mode: Mode = "robust"
    expected_length: float = Field(10 / 3, gt=0)
    """s; mean length of a segment, k of the geometric prior: 100 frames of a Kinect (ALGORITHMS 2)."""
    threshold: float = Field(0.03, ge=0)
    """m; d_thresh, how far hand and a relevant object move apart at most; faithful only (ALGORITHMS 2)."""
    rate: float = Field(30.0, gt=0, le=1000)
    """Hz; a Kinect's, to which the robust score resamples (ALGORITHMS 2)."""
    window: float = Field(1 / 3, gt=0)
    """s over which displacements are taken: 10 frames of a Kinect (ALGORITHMS 2)."""
    slack: float = Field(0.003, gt=0)
    """m; how far a still or carried object moves by itself, beyond the noise (ALGORITHMS 2)."""
    hand_radius: float = Field(0.05, gt=0)
    """m; half a hand's breadth: turning by an angle counts as moving by that times this."""
    clip: float = Field(30.0, gt=0)
    """nats that the displacement over one window may say about an object (ALGORITHMS 2)."""
    object_penalty: float = Field(3.0, ge=0)
    """nats that each relevant object costs (ALGORITHMS 2)."""
    reference_length: float = Field(0.02, gt=0)
    """m; ℓ_ref, distance to the reference that costs one nat (ALGORITHMS 2)."""
    reference_limit: float = Field(20.0, gt=0)
    """nats; C, the cost of a reference however far away it is, and of the table."""
    shortest: float = Field(1 / 6, ge=0)
    """s that a segment lasts at least: 5 frames of a Kinect (ALGORITHMS 2)."""
    touch: float = Field(0.01, ge=0)
    """m from an object's box within which a resting hand touches it; an unknown size is never touched."""
    visit: float = Field(0.3, gt=0)
    """s that a free hand rests on an object at least, for that to be a reach of its own."""
    rest_speed: float = Field(0.04, ge=0)
    """m/s below which the hand rests; people slow down to this while their fingers close."""
    rest_limit: float = Field(0.5, ge=0)
    """s of rest on either side of a carry that go to the carry: time for fingers to close and open."""


class PolicySettings(_Section):
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


class Learning(_Section):
    """Trials, updates, evaluation, reformulation (the paper, sections 5 and 6; ALGORITHMS 4 and 5)."""

    alpha: float = Field(default=0.8, gt=0, le=1)
    """α: P(β=1|π) from which an option is accepted."""
    evaluation_starts: int = Field(default=20, ge=1)
    """perturbed starts over which P is estimated."""
    reproduction_starts: int = Field(default=10, ge=1)
    """perturbed starts from which the whole task is reproduced at the end of `learn`."""
    shift: float = Field(default=0.02, ge=0)
    """m by which each block is moved at a perturbed start, at most, along x and y."""
    turn: float = Field(default=15.0, ge=0)
    """degrees by which it is turned, at most."""

    imitation_first: bool = True
    """the first trial is the imitated policy itself; where it will do, nothing is explored."""
    first_rollouts: int = Field(default=10, ge=2)
    """trials before the first update (authors' code)."""
    rollouts: int = Field(default=5, ge=1)
    """new trials before each further update."""
    reused: int = Field(default=5, ge=0)
    """best earlier trials used again in an update."""
    updates: int = Field(default=5, ge=1)
    """U; with the schedule above 30 trials."""
    more_updates: int = Field(default=2, ge=0)
    """further ones where α lies within the interval of the best policy's P."""
    eliteness: float = Field(default=10.0, gt=0)
    """h in P ∝ exp(−h(S − min)/(max − min))."""
    exploration: Literal["constant", "per-kernel", "covariance", "power"] = "constant"
    """constant over a rollout and a scalar cost (PI^BB), per kernel with cost to go (PI²), constant with a
    covariance that is adapted (PI²-CMA), or constant with rewards of the best trials ever (PoWER)."""
    pose_noise: float = Field(default=0.02, ge=0)
    """standard deviation, as a share of the mean absolute pose weight."""
    gripper_noise: float = Field(default=40.0, ge=0)
    """N, standard deviation; where the phase falls evenly, 40 found a grasp more often than 60."""
    gripper_from_opening: bool = True
    """the gripper's first weights close it while the hand was seen closed; otherwise they are 0. False in the
    faithful mode, where the force is to be discovered."""
    seen_force: float = Field(default=20.0, gt=0)
    """N by which it closes then; in scripted schedules 20 held, 10 slipped (ALGORITHMS 5)."""
    closed_share: float = Field(default=0.25, gt=0, lt=1)
    """the hand counts as closed up to this share of the way from the narrowest opening to the widest."""
    opening_range: float = Field(default=0.01, gt=0)
    """m that lie between these two at least; less may be one opening, seen with noise."""
    least_noise: float = Field(default=0.1, ge=0, le=1)
    """the factor max(least_noise, (U − i − 1)/U) scales the noise at update i; with "covariance", no
    direction has less than this share of the first noise."""
    covariance_rate: float = Field(default=0.3, ge=0, le=1)
    """share of the covariance that an update takes from its trials (Stulp & Sigaud 2012 take 0.2 to 0.5)."""
    reward_cost: float = Field(default=20.0, gt=0)
    """PoWER's reward is exp(−cost / this); the paper's C."""
    goal_noise: float = Field(default=0.0, ge=0)
    """m, standard deviation of the goal's position, which is then learned; the authors' robot had 0.03."""
    goal_turn_noise: float = Field(default=0.0, ge=0)
    """of each component of the goal's quaternion, likewise; the authors' robot had 0.07."""
    improve_by: Literal["total", "terminal-first", "terminal"] = "terminal"
    """which cost improves the policy: the total; the terminal cost until a trial succeeds, then the total; or
    the terminal cost. But for "total", the noise narrows only once a trial has succeeded."""
    converged_below: float = Field(default=3.0, ge=0)
    """two consecutive costs of the mean policy closer than this: converged (authors' code)."""
    observe_trials: bool = False
    """objects' poses in trials come from the virtual camera and the tracker, not from the physics; the
    paper's come from a Kinect."""
    observe_rate: float = Field(default=2.0, gt=0, le=60)
    """frames a second that the camera takes of a trial, besides those where a skill starts and ends."""
    observe_width: int = Field(default=320, ge=160, le=1280)
    """pixels of the camera's picture across, three quarters of it down; a Kinect's are 640."""
    candidates: int = Field(default=2, ge=0)
    """best trials that compete with the mean policy after each update; 0: the mean alone."""
    candidate_starts: int = Field(default=5, ge=1)
    """perturbed starts on which the candidates compete."""
    margin: float = Field(default=0.75, gt=0, le=1)
    """share of `near` and `near_angle` within which a success is a firm one."""
    sure: float = Field(default=0.9, gt=0, le=1)
    """share of firm successes from which a policy is accepted at once; one with less, but P ≥ α, is accepted
    when improvement has ended."""

    judge: Literal["pose", "cost"] = "pose"
    """β: every relevant body near its shown pose and at rest, or terminal cost below `cost_threshold`."""
    near: float = Field(default=0.02, gt=0)
    """m from the shown pose in the reference's frame."""
    near_angle: float = Field(default=15.0, gt=0)
    """degrees, likewise."""
    symmetric: tuple[str, ...] = ()
    """objects that count as unturned when they look the same: boxes, up to a tenth between their sides."""
    rest_time: float = Field(default=0.2, gt=0)
    """s over which a body at rest moves less than a tenth of `near` and `near_angle`."""
    cost_threshold: float = Field(default=20.0, gt=0)
    """C of the faithful β."""
    position_cost: float = Field(default=100.0, ge=0)
    """per m of Σ|Δxyz| (authors' code)."""
    turn_cost: float = Field(default=11.0, ge=0)
    """per unit of Σ|Δq| (authors' code)."""
    acceleration_cost: float = Field(default=1e-4, ge=0)
    """per (m/s²)² and control tick of the hand."""
    switch_cost: float = Field(default=5.0, ge=0)
    """for each opening or closing of the gripper (the paper, section 6)."""
    closed_end_cost: float = Field(default=10.0, ge=0)
    """terminal, for ending closed where the demonstration then has the hand leave; without it, holding on is
    cheaper by the opening saved."""
    unreachable_cost: float = Field(default=200.0, ge=0)
    """terminal cost of a trial that was stopped at a pose out of reach."""

    initiation_threshold: float = Field(default=0.5, gt=0, le=1)
    """p of success from which a start is in an option's initiation set: more likely than not."""
    initiation_doubt: float = Field(default=1.0, gt=0)
    """trials that would have to succeed at an untried place for p = 0.5 there."""

    model_threshold: float = Field(default=50.0, ge=0)
    """α_model: natural-log gap to the best abstraction within which others are tried."""
    keep_failed: bool = False
    """pose weights start from those of the formulation before even where it never succeeded, as in the paper;
    else from the imitation then: without the gripper, what costs least may be to push the object about."""
    reformulate: bool = True
    """false: each skill as it was first stated, pose alone; what Algorithm 1 adds is then missing."""
    formulations: int = Field(default=12, ge=1)
    """formulations tried in a session, over all segments, before it is given up."""


class World(_Section):
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


class Settings(_Section):
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
        "more_updates": 0,
        "keep_failed": True,
        "improve_by": "total",
        "judge": "cost",
        "closed_end_cost": 0.0,
        "gripper_noise": 60.0,
        "gripper_from_opening": False,
    },
    "policy": {"gripper_decay": 2.0, "orientation": "quaternion"},
}


_CST: dict[str, dict[str, Any]] = {"segmentation": {"mode": "cst", "shortest": 0.0, "rest_limit": 0.0}}

_OF_MODE = {"faithful": _FAITHFUL, "cst": _CST}


def load_settings(path: Path | None = None, overrides: dict[str, Any] | None = None) -> Settings:
    """Settings of a mode, changed by a TOML file and then by ``overrides`` (nested, as in the file).

    Raises:
        FileError: the file is missing or is not TOML.
        UsageError: an unknown setting or a value out of range; the message lists what is valid.
    """
    given: dict[str, Any] = {}
    if path is not None:
        given = _read_toml(path)
    given = _merge(given, overrides or {})
    base = _OF_MODE.get(str(given.get("mode")), {})
    return parse_settings(_merge(base, given), str(path or "settings"))


def parse_settings(values: dict[str, Any], where: str = "settings") -> Settings:
    """Settings from nested plain values; errors as in `load_settings`."""
    try:
        return Settings.model_validate(values)
    except ValidationError as error:
        raise _readable(error, where) from None


def settings_from_toml(text: str) -> Settings:
    """The inverse of `to_toml`."""
    return parse_settings(tomllib.loads(text))


def to_toml(settings: Settings) -> str:
    """All settings as TOML, defaults included."""
    top, tables = [], []
    for name, value in settings.model_dump().items():
        if isinstance(value, dict):
            tables.append(f"\n[{name}]\n" + "".join(f"{k} = {_toml(v)}\n" for k, v in value.items()))
        else:
            top.append(f"{name} = {_toml(value)}\n")
    return "".join(top) + "".join(tables)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return repr(value)


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise FileError(path, "no such settings file", "Pass a TOML file to --settings.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})") from None
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not TOML ({error})") from None


def _merge(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in over.items():
        inner = merged.get(key)
        merged[key] = _merge(inner, value) if isinstance(inner, dict) and isinstance(value, dict) else value
    return merged


def _readable(error: ValidationError, where: str) -> UsageError:
    first = error.errors()[0]
    path = [str(part) for part in first["loc"]]
    if first["type"] == "extra_forbidden":
        model: type[BaseModel] = Settings
        for part in path[:-1]:
            model = type(model.model_fields[part].default)
        section = f" [{'.'.join(path[:-1])}]" if path[1:] else ""
        return UnknownNameError(f"setting in {where}{section}:", path[-1], model.model_fields)
    return UsageError(f"{where}: {'.'.join(path)} = {first['input']!r}: {first['msg'].lower()}.")
