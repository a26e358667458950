"""Constants of segmenting, and the modes."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from imitate.settings.section import Section

Mode = Literal["robust", "faithful", "cst"]


class Segmentation(Section):
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
    long_window: float = Field(1.0, gt=0)
    """s, likewise, where a body's noise is more than its slack, as far as a ``window`` is not sure."""
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
    grasp: float = Field(0.55, ge=0)
    """s that fingers take, at least, to close on something and to open again; a shorter carry is doubted."""
    touch: float = Field(0.01, ge=0)
    """m from an object's box within which a resting hand touches it; an unknown size is never touched."""
    visit: float = Field(0.3, gt=0)
    """s that a free hand rests on an object at least, for that to be a reach of its own."""
    rest_speed: float = Field(0.04, ge=0)
    """m/s below which the hand rests; people slow down to this while their fingers close."""
    rest_limit: float = Field(0.5, ge=0)
    """s of rest on either side of a carry that go to the carry: time for fingers to close and open."""
