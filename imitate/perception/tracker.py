"""Following blocks and the hand from frame to frame with the annealed particle filter.

A block is first looked for close to where it was and to where it would be going on as before. Where that
explains its pixels worse than usual, a wide search follows, also around where its coloured pixels have gone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, compose, conjugate, inverse, normalised, quaternion_multiply
from imitate.perception.block import Block
from imitate.perception.colour import is_hue
from imitate.perception.eye import Eye
from imitate.perception.hand import (
    SIDES,
    SLACK,
    Hand,
    around_finger,
    finger_poses,
    hand_of_pixels,
    hand_score,
)
from imitate.perception.particles import anneal, moved
from imitate.perception.shapes import Float, Mask, Pixels, agreement, box_depth
from imitate.settings import Perception

AT_REST = np.array([0.001, 0.001, 0.001, 0.01, 0.01, 0.01])
MOVING = np.array([0.006, 0.006, 0.006, 0.15, 0.15, 0.15])
FINGERS = np.array([0.004, 0.004, 0.004, 0.04, 0.04, 0.04, 0.004])
"""standard deviations of a body's change around a guess: m and rad, of the hand also its opening in m."""
WORSE = 0.1
"""log-likelihood a pixel by which a block's fit may fall short of the usual before a wide search."""
FORGET = 0.02
"""log-likelihood a pixel by which what is usual sinks with each frame."""
SEARCH = 0.12
"""m around a block's last place in which its colour is looked for."""
FEWEST = 4
"""pixels of a block's colour, below which it is lost from view."""
VISIBLE = 0.1
"""share of a block's outline that must show its colour, else it is lost from view."""


class BlockTracker:
    """Follows one block of known size; ``name`` starts with its hue."""

    def __init__(self, block: Block, name: str, settings: Perception) -> None:
        self._hue = name.rstrip("0123456789")
        self._size, self._pose = block.size, np.array(block.pose)
        self._settings = settings
        self._reach = float(np.linalg.norm(block.size)) / 2 + 0.012
        self._velocity = np.zeros(3)
        self._usual = -np.inf
        self._time: float | None = None
        self._shown: Array | None = None  # the middle of its visible pixels, from its pose
        self._lost = False

    def follow(
        self,
        pixels: Pixels,
        t: float,
        eye: Eye,
        generator: np.random.Generator,
        others: Sequence[BlockTracker] = (),
    ) -> Array | None:
        """(7,) the block's pose in this frame; None where it cannot be seen.

        Pixels of the same hue that one of the ``others`` explains are left to it.
        """
        alike = [other for other in others if other._hue == self._hue and other is not self]
        guesses = self._guesses(pixels, t, eye, alike)
        near = pixels.where(eye.window(self._pose[:3] + guesses, self._reach, self._settings.pixels))
        near = near.where(~_explained(near, alike))
        own = is_hue(near.hue, self._hue) & (near.depth > 0)
        if own.sum() < FEWEST:
            self._lost = True
            return None
        pose, fit = self._search(near, own, guesses, generator)
        if not self._is_visible(near, own, pose):
            self._lost = True
            return None
        self._usual = max(fit, self._usual - FORGET)
        self._accept(pose, t, near, own)
        return pose

    def _search(
        self, near: Pixels, own: Mask, guesses: Array, generator: np.random.Generator
    ) -> tuple[Array, float]:
        """(pose, log-likelihood a pixel) that explain the pixels best."""
        settings, pixels = self._settings, int(own.sum())

        def score(changes: Array) -> Float:
            depth = box_depth(near, moved(self._pose, changes), self._size)
            return agreement(near, own, depth, settings.depth_noise)

        particles = _spread(guesses[:2], AT_REST, settings.particles // 2, generator)
        best = anneal(particles, score, settings.layers // 2, generator)
        if self._lost or best.score / pixels < self._usual - WORSE:
            particles = _spread(guesses, MOVING, settings.particles, generator)
            particles[0] = best.mean
            wide = anneal(particles, score, settings.layers, generator)
            best = max(best, wide, key=lambda estimate: estimate.score)
        return normalised(moved(self._pose, best.mean[None])[0]), best.score / pixels

    def _guesses(self, pixels: Pixels, t: float, eye: Eye, alike: Sequence[BlockTracker]) -> Array:
        """(G, 3) shifts since the last frame."""
        going_on = self._velocity * (t - self._time) if self._time is not None else np.zeros(3)
        shifts = [np.zeros(3), going_on]
        reach = SEARCH if not self._lost else 10.0
        near = pixels.where(eye.window(self._pose[None, :3], reach, 6000))
        near = near.where(~_explained(near, alike))
        own = is_hue(near.hue, self._hue) & (near.depth > 0)
        if self._shown is not None and own.sum() >= FEWEST:
            shifts.append(np.median(near.where(own).points(), axis=0) - self._pose[:3] - self._shown)
        return np.array(shifts)

    def _is_visible(self, near: Pixels, own: Mask, pose: Array) -> bool:
        hit = np.isfinite(box_depth(near, pose[None], self._size)[0])
        return bool((hit & own).sum() > max(3, VISIBLE * hit.sum()))

    def _accept(self, pose: Array, t: float, near: Pixels, own: Mask) -> None:
        if self._time is not None and t > self._time:
            self._velocity = np.zeros(3) if self._lost else (pose[:3] - self._pose[:3]) / (t - self._time)
        self._shown = np.median(near.where(own).points(), axis=0) - pose[:3]
        self._pose, self._time, self._lost = pose, t, False


def _explained(pixels: Pixels, trackers: Sequence[BlockTracker]) -> Mask:
    """(M,) which pixels show a block where its tracker has it."""
    taken = np.zeros(len(pixels.depth), bool)
    for tracker in trackers:
        expected = box_depth(pixels, tracker._pose[None], tracker._size)[0]
        taken |= np.abs(pixels.depth - expected) < 3 * tracker._settings.depth_noise
    return taken


class HandTracker:
    """Follows the hand by its two fingers."""

    def __init__(self, settings: Perception) -> None:
        self._settings = settings
        self._hand: Hand | None = None
        self._velocity = np.zeros(3)
        self._time = 0.0
        # Turns are about the origin that the paper gives the hand, which may lie behind the fingertips.
        self._origin = np.array([0, 0, -settings.hand_offset, 0, 0, 0, 1])

    def follow(self, pixels: Pixels, t: float, eye: Eye, generator: np.random.Generator) -> Array | None:
        """(7,) the tool-centre point's pose in this frame; None where a finger cannot be seen."""
        settings = self._settings
        shown = hand_of_pixels(pixels, settings)
        if shown is None:
            self._hand = None
            return None
        before = self._hand or shown
        base = compose(before.pose, self._origin)
        going_on = np.zeros(7)
        going_on[:3] = self._velocity * (t - self._time) if self._hand else 0
        guesses = np.stack([np.zeros(7), going_on, _change(before, shown, self._origin)])
        particles = _spread(guesses, FINGERS, settings.particles, generator)

        def hands(changes: Array) -> tuple[Array, Array]:
            poses = compose(moved(base, changes), inverse(self._origin))
            return poses, np.maximum(before.opening + changes[:, 6], 0)

        left, right = (self._near(pixels, before, shown, eye, side) for side in SIDES)

        def score(changes: Array) -> Float:
            return hand_score((left, right), *hands(changes), settings)

        best = anneal(particles, score, settings.layers, generator)
        poses, openings = hands(best.mean[None])
        pose = normalised(poses[0])
        if self._hand and t > self._time:
            self._velocity = (pose[:3] - before.pose[:3]) / (t - self._time)
        self._hand, self._time = Hand(pose, float(openings[0])), t
        return pose

    def _near(self, pixels: Pixels, before: Hand, shown: Hand, eye: Eye, side: int) -> Pixels:
        hands = np.stack([before.pose, shown.pose])
        openings = np.array([before.opening, shown.opening])
        middles = finger_poses(hands, openings, self._settings, side)[:, :3]
        reach = self._settings.finger_length / 2 + self._settings.finger_radius + SLACK
        window = pixels.where(eye.window(middles, reach, 3 * self._settings.pixels))
        return around_finger(window, hands, openings, self._settings, side)


def _change(before: Hand, after: Hand, origin: Array) -> Array:
    """(7,) shift, rotation vector and opening that lead from one hand to another."""
    a, b = compose(before.pose, origin), compose(after.pose, origin)
    turn = Rotation.from_quat(quaternion_multiply(b[3:], conjugate(a[3:]))).as_rotvec()
    return np.concatenate([b[:3] - a[:3], turn, [after.opening - before.opening]])


def _spread(guesses: Array, deviations: Array, count: int, generator: np.random.Generator) -> Array:
    """(count, D) particles around guesses (G, ≤ D), the guesses themselves first."""
    centres = np.zeros((len(guesses), len(deviations)))
    centres[:, : guesses.shape[1]] = guesses
    which = np.arange(count) % len(guesses)
    drawn = centres[which] + deviations * generator.standard_normal((count, len(deviations)))
    drawn[: len(guesses)] = centres
    return drawn
