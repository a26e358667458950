"""Following the hand by its two fingers with the annealed particle filter, also while one is hidden."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, compose, conjugate, inverse, normalised, quaternion_multiply
from imitate.perception.evidence import Evidence, Fit, evidence_for
from imitate.perception.eye import View
from imitate.perception.hand import NAMES, SIDES, SLACK, Hand, finger_offsets, hand_of_pixels
from imitate.perception.particles import anneal, around, expected, guessed, moved
from imitate.perception.shapes import Float, Pixels, Places, cylinder_nearness, places
from imitate.perception.tracker import UNSEEN, Motion, Sight
from imitate.perception.usual import Usual
from imitate.settings import Perception

NEAR = np.array([0.002, 0.002, 0.002, 0.02, 0.02, 0.02, 0.002])
FAR = np.array([0.006, 0.006, 0.006, 0.06, 0.06, 0.06, 0.006])
"""standard deviations of the hand's change around a guess, m and rad, the last of its opening in m."""
ENOUGH = np.array([0.0005, 0.0005, 0.0005, 0.008, 0.008, 0.008, 0.0005])
"""standard deviations at which a search ends: a tenth of what is asked of it."""
FEWEST = 12
"""pixels that show the fingers, below which the hand is lost."""
AGREEING = 0.5
"""share of the pixels that agree, of the usual share, below which it is."""
FINE = 2
"""pixels between those in which a lost hand is looked for."""


class HandTracker:
    """Follows the hand by its two fingers."""

    hue = None

    def __init__(self, settings: Perception) -> None:
        self._settings = settings
        self._hand: Hand | None = None
        self._velocity, self._time = np.zeros(7), 0.0
        self._usual = Usual()
        self._motion: Motion | None = None
        # Turns are about the origin that the paper gives the hand, which may lie behind the fingertips.
        self._origin = np.array([0, 0, -settings.hand_offset, 0, 0, 0, 1])

    @property
    def is_lost(self) -> bool:
        """Whether it was not seen in the last frame."""
        return self._hand is None

    @property
    def opening(self) -> float:
        """Metres between the fingers' surfaces in the last frame; NaN where it was not seen."""
        return np.nan if self._hand is None else self._hand.opening

    @property
    def motion(self) -> Motion | None:
        """From the last frame to this one; None unless it was seen in both."""
        return self._motion

    def nearness(self, pixels: Pixels) -> Float:
        """(M,) one over the depth of the nearer finger's surface, 0 where there is none."""
        if self._hand is None:
            return np.zeros(len(pixels.depth), np.float32)
        pose, opening = places(self._hand.pose[None]), np.array([self._hand.opening])
        nearest: Float = np.maximum(*(self._finger(pixels, pose, opening, side)[0] for side in SIDES))
        return nearest

    def follow(self, view: View, generator: np.random.Generator) -> Sight:
        """Where the hand's tool-centre point is in this frame."""
        before = self._hand
        found = None
        if before is not None:
            found = self._search(view, before, self._guesses(view.frame.t), NEAR, 0.5, generator)
        if found is None or before is None or self._usual.is_worse(_score(found[1])):
            again = self._again(view, before, generator)
            found = max((f for f in (found, again) if f), key=lambda f: _score(f[1]), default=None)
        if found is None or not self._is_shown(found[1]):
            self._hand, self._motion = None, None
            return UNSEEN
        hand, fits = found
        self._accept(before, hand, fits, view.frame.t)
        return Sight(hand.pose, self._confidence(fits))

    def _guesses(self, t: float) -> Array:
        """(2, 7) changes since the last frame: none, and going on as before."""
        return np.stack([np.zeros(7), self._velocity * (t - self._time)])

    def _again(
        self, view: View, before: Hand | None, generator: np.random.Generator
    ) -> tuple[Hand, list[Fit]] | None:
        """A search around where the fingers' pixels put the hand, and around where it was."""
        pixels = view.pixels((slice(0, None, FINE), slice(0, None, FINE)))
        shown = hand_of_pixels(pixels, self._settings, before)
        if shown is None:
            return None
        here = np.zeros((1, 7))
        if before is None:  # nothing but the pixels to start from: twice
            first, _ = self._search(view, shown, here, FAR, 1.0, generator)
            return self._search(view, first, here, FAR, 1.0, generator)
        guesses = np.concatenate([self._guesses(view.frame.t), _change(before, shown, self._origin)[None]])
        return self._search(view, before, guesses, FAR, 1.0, generator)

    def _search(
        self,
        view: View,
        before: Hand,
        guesses: Array,
        spread: Array,
        share: float,
        generator: np.random.Generator,
    ) -> tuple[Hand, list[Fit]]:
        """The hand that explains the pixels around both fingers best, with a share of the particles."""
        base = compose(before.pose, self._origin)

        def hands(changes: Array) -> tuple[Places, Array]:
            opening = np.maximum(before.opening + changes[:, 6], 0)
            return guessed(base, changes).part(-self._origin[:3]), opening

        evidence = [self._look(view, *hands(guesses), side) for side in SIDES]

        def score(changes: Array) -> Float:
            total, (poses, openings) = expected(changes, guesses, 3 * spread), hands(changes)
            for side, seen in zip(SIDES, evidence, strict=True):
                total += seen.score(self._finger(seen.pixels, poses, openings, side))
            return np.asarray(total, np.float32)

        particles = around(guesses, spread, round(share * self._settings.particles), generator)
        best = anneal(particles, score, self._settings.layers, generator, ENOUGH)
        final, opening = hands(best.mean[None])
        fits = [
            seen.fit(self._finger(seen.pixels, final, opening, side)[0])
            for side, seen in zip(SIDES, evidence, strict=True)
        ]
        pose = normalised(compose(moved(base, best.mean[None])[0], inverse(self._origin)))
        return Hand(pose, float(opening[0])), fits

    def _look(self, view: View, hands: Places, openings: Array, side: int) -> Evidence:
        settings = self._settings
        middles = hands.part(finger_offsets(openings, settings, side))
        half = np.array([0, 0, settings.finger_length / 2])
        ends = np.concatenate([middles.part(half).at, middles.part(-half).at])
        pixels = view.around(ends, settings.finger_radius + SLACK, settings.pixels // 2)
        return evidence_for(NAMES[SIDES.index(side)], pixels, (), settings.depth_noise)

    def _finger(self, pixels: Pixels, hands: Places, openings: Array, side: int) -> Float:
        middles = hands.part(finger_offsets(openings, self._settings, side))
        radius, length = self._settings.finger_radius, self._settings.finger_length
        return cylinder_nearness(pixels.origin, pixels.rays, middles, radius, length)

    def _is_shown(self, fits: list[Fit]) -> bool:
        agreeing = self._usual.relative(_agreement(fits)) >= AGREEING
        return sum(fit.shown for fit in fits) >= FEWEST and agreeing

    def _confidence(self, fits: list[Fit]) -> float:
        return self._usual.relative(_agreement(fits)) * min(1.0, sum(fit.visible for fit in fits) / 0.6)

    def _accept(self, before: Hand | None, hand: Hand, fits: list[Fit], t: float) -> None:
        self._motion = Motion(before.pose, hand.pose) if before else None
        self._velocity = np.zeros(7)
        if before and t > self._time:
            self._velocity[:3] = (hand.pose[:3] - before.pose[:3]) / (t - self._time)
        self._usual.learn(_score(fits), _agreement(fits))
        self._hand, self._time = hand, t


def _score(fits: list[Fit]) -> float:
    return float(np.mean([fit.score for fit in fits]))


def _agreement(fits: list[Fit]) -> float:
    shown = sum(fit.shown for fit in fits)
    return shown / max(shown + sum(fit.against + fit.missed for fit in fits), 1)


def _change(before: Hand, after: Hand, origin: Array) -> Array:
    """(7,) shift, rotation vector and opening that lead from one hand to another."""
    a, b = compose(before.pose, origin), compose(after.pose, origin)
    turn = Rotation.from_quat(quaternion_multiply(b[3:], conjugate(a[3:]))).as_rotvec()
    return np.concatenate([b[:3] - a[:3], turn, [after.opening - before.opening]])
