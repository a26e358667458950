"""What a Kinect makes of a true depth picture: noise, quantisation, shadows, flying pixels and holes.

Axial and lateral noise, and their growth with the angle of view: Nguyen, Izadi & Lovell, "Modeling Kinect
Sensor Noise for Improved 3D Reconstruction and Tracking", 2012. Quantisation: Khoshelham & Elberink,
"Accuracy and Resolution of Kinect Depth Data for Indoor Mapping Applications", 2012. Shadows follow from the
distance between projector and camera. How often pixels fly or stay dark was not published as a number: those
are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array
from imitate.rgbd import Intrinsics

JUMP = 0.015
"""m between neighbouring pixels from which they show different surfaces."""
NEAREST = 0.05
"""m below which no depth is computed with."""
STEEPEST = np.deg2rad(82.0)
"""rad at which the growth of the noise with the angle is cut off; the formulas go to infinity at 90°."""
Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Sensor:
    """A depth sensor; the defaults are a Kinect's.

    Attributes:
        shortest, longest: metres between which there is a reading.
        angled: whether axial noise grows beyond 60° (Nguyen et al., equation 3).
        lateral: times Nguyen's standard deviation of an edge's place, 0.8 pixels at 640×480 seen head-on.
        step: 1/m, quantum of 1/depth; 2.85e-3 is Khoshelham's 2.85e-5 z² in centimetres.
        baseline: metres from camera to projector, along the picture's x.
        flying: share of an edge's pixels that show a depth between the two surfaces; ours.
        grazing: degrees of the angle of view at which readings start to fail and all have failed; ours.
        dark: brightness 0…1 of the brightest channel below which nothing comes back; ours.
        glare: brightness 0…1 of the darkest channel from which a highlight blinds the sensor; ours.
        holes: share of other pixels without a reading; ours.
    """

    shortest: float = 0.4
    longest: float = 3.5
    angled: bool = True
    lateral: float = 1.0
    step: float = 2.85e-3
    baseline: float = 0.075
    flying: float = 0.1
    grazing: tuple[float, float] = (70.0, 86.0)
    dark: float = 0.08
    glare: float = 0.96
    holes: float = 0.002


KINECT = Sensor()
AXIAL = Sensor(
    angled=False, lateral=0, step=0, baseline=0, flying=0, grazing=(90, 91), dark=0, glare=2, holes=0
)
"""Nguyen's axial noise below 60° and nothing else."""
SENSORS = {"kinect": KINECT, "axial": AXIAL}


def axial_noise(depth: Array) -> Array:
    """Standard deviation in metres of a Kinect's depth at ``depth`` metres (Nguyen et al. 2012)."""
    return np.asarray(0.0012 + 0.0019 * (np.asarray(depth) - 0.4) ** 2)


def read_depth(
    depth: Array, colour: NDArray[np.uint8], i: Intrinsics, sensor: Sensor, generator: np.random.Generator
) -> Depth:
    """(H, W) what the sensor reads, metres; 0 where it reads nothing.

    Args:
        depth: (H, W) the true depth, metres.
        colour: (H, W, 3) the surfaces under visible light; dark ones return no infrared either.
        i: of both pictures; noise in pixels scales with their width.
        sensor: whose model.
        generator: of every random draw.
    """
    scale = i.width / 640
    true = depth.astype(np.float32)
    angle = incidence(true, i) if sensor.angled or sensor.lateral or sensor.grazing[0] < 90 else None
    read = np.array(depth, np.float64)
    if sensor.lateral or sensor.flying:
        read = _edges(true, angle, sensor, scale, generator).astype(np.float64)
    deviation = axial_noise(read)
    if sensor.angled and angle is not None:
        steep = np.where(angle > np.pi / 3, angle, 0)
        deviation += 0.0001 / np.sqrt(np.maximum(read, NEAREST)) * steep**2 / (np.pi / 2 - steep) ** 2
    read += deviation * generator.standard_normal(read.shape)
    if sensor.step:
        read = 1 / (sensor.step * np.maximum(np.round(1 / (sensor.step * np.maximum(read, NEAREST))), 1))
    blind = (read < sensor.shortest) | (read > sensor.longest)
    if sensor.baseline:
        blind |= shadowed(true, i.fx * sensor.baseline)
    if angle is not None and sensor.grazing[0] < 90:
        first, last = np.deg2rad(sensor.grazing)
        blind |= generator.random(read.shape, np.float32) < (angle - first) / (last - first)
    if sensor.holes:
        blind |= generator.random(read.shape, np.float32) < sensor.holes
    if sensor.dark or sensor.glare <= 1:
        red, green, blue = np.moveaxis(colour, -1, 0)
        blind |= np.maximum(np.maximum(red, green), blue) < 255 * sensor.dark
        blind |= np.minimum(np.minimum(red, green), blue) > 255 * sensor.glare
    read[blind] = 0
    return read.astype(np.float32)


def incidence(depth: Depth, i: Intrinsics) -> Depth:
    """(H, W) radians between the line of sight and the surface's normal, at most `STEEPEST`.

    1/depth is linear over a plane's picture, so that its differences give the normal exactly; of the
    differences to both sides the smaller is taken, which is the one that does not cross an edge.
    """
    q = np.asarray(1 / depth, np.float32)
    across, down = _slope(q, 1) * np.float32(i.fx), _slope(q, 0) * np.float32(i.fy)
    x = ((np.arange(i.width) - i.cx) / i.fx).astype(np.float32)
    y = ((np.arange(i.height) - i.cy) / i.fy).astype(np.float32)[:, None]
    along = q - x * across - y * down
    cosine = q / np.sqrt((across**2 + down**2 + along**2) * (1 + x**2 + y**2))
    return np.minimum(np.arccos(np.clip(cosine, 0, 1)), np.float32(STEEPEST))


def shadowed(depth: Depth, reach: float) -> Mask:
    """(H, W) which pixels the projector does not light: something between hides them from it.

    Args:
        depth: the true depth, metres.
        reach: focal length times baseline, pixel·m; positive: the projector stands to the right.

    A pixel at column u appears in the projector's picture at u − reach/depth. Where a pixel farther right
    appears farther left there, the left one is hidden.
    """
    column = np.arange(depth.shape[1], dtype=np.float32) - np.float32(reach) / depth
    least = np.minimum.accumulate(column[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(column > least + 1)


def _slope(q: Depth, axis: int) -> Depth:
    """The one-sided difference of least size, per pixel, along an axis."""
    step = np.diff(q, axis=axis)
    before = np.concatenate([step.take([0], axis), step], axis)
    after = np.concatenate([step, step.take([-1], axis)], axis)
    return np.where(np.abs(before) < np.abs(after), before, after)


def _edges(
    depth: Depth, angle: Depth | None, sensor: Sensor, scale: float, generator: np.random.Generator
) -> Depth:
    """The depth with its edges frayed sideways, and some pixels flying between the two surfaces."""
    square = np.ones((3, 3), np.uint8)
    near, far = cv2.erode(depth, square), cv2.dilate(depth, square)
    edge = (far - near > JUMP) & (far - near > 0.03 * near)
    rows, columns = np.nonzero(cv2.dilate(edge.astype(np.uint8), np.ones((5, 5), np.uint8)))
    frayed = depth.copy()
    if sensor.lateral and angle is not None:
        seen = angle[rows, columns]
        deviation = sensor.lateral * scale * (0.8 + 0.035 * seen / (np.pi / 2 - seen))
        shift = np.round(deviation * generator.standard_normal((2, len(rows)))).astype(int)
        there = depth[
            np.clip(rows + shift[0], 0, depth.shape[0] - 1),
            np.clip(columns + shift[1], 0, depth.shape[1] - 1),
        ]
        other = np.abs(there - depth[rows, columns]) > JUMP
        frayed[rows[other], columns[other]] = there[other]
    rows, columns = np.nonzero(edge)
    flies = generator.random(len(rows)) < sensor.flying
    rows, columns = rows[flies], columns[flies]
    between = generator.random(len(rows), np.float32)
    frayed[rows, columns] = near[rows, columns] + between * (far - near)[rows, columns]
    return frayed
