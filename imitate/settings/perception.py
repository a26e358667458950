"""Constants of seeing."""

from __future__ import annotations

from pydantic import Field, ValidationInfo, field_validator

from imitate.settings.section import Section


class Perception(Section):
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
    sensor: str = ""
    """frame of a cloud: optical (x right, y down, z forward), graphics (y up, z back), body (x forward, z
    up), viewpoint (a world, seen from a PCD file's VIEWPOINT), or the camera's pose in it, x,y,z,qx,qy,qz,qw,
    m; found where empty."""
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

    @field_validator("sensor")
    @classmethod
    def _known_sensor(cls, given: str) -> str:
        if given in ("", "optical", "graphics", "body", "viewpoint"):
            return given
        try:
            pose = [float(word) for word in given.split(",")]
        except ValueError:
            pose = []
        if len(pose) != 7 or abs(sum(q * q for q in pose[3:]) - 1) > 1e-3:
            raise ValueError(
                "expected optical, graphics, body, viewpoint, or seven numbers, x,y,z in metres and a unit "
                f"quaternion qx,qy,qz,qw; got {given!r}"
            )
        return given
