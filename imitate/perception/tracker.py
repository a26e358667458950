"""Following blocks from frame to frame with the annealed particle filter.

A block at rest is only looked at: as long as its pixels agree with where it is, nothing is searched. One that
may have moved is looked for with few particles close to where it was, to where it would be going on as
before, and to where the hand that touches it would have taken it; with many, and around where its pixels have
gone, when that explains its pixels worse than usual; and over the whole table when it is lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.geometry import Array, compose, conjugate, inverse, normalised, quaternion_multiply, rotate
from imitate.perception.block import Block
from imitate.perception.evidence import Body, BoxEvidence, Fit, evidence_for
from imitate.perception.eye import View
from imitate.perception.lost import YAWS, patches
from imitate.perception.particles import anneal, around, expected, guessed, moved
from imitate.perception.rest import Rest
from imitate.perception.shapes import Float, Pixels, box_nearness, places
from imitate.perception.surface import POINTS, SurfaceEvidence
from imitate.perception.symmetry import flat, half_height, nearest_alike, tilt
from imitate.perception.usual import Usual
from imitate.settings import Perception

AT_REST = np.array([0.001, 0.001, 0.001, 0.01, 0.01, 0.01])
MOVING = np.array([0.006, 0.006, 0.006, 0.15, 0.15, 0.15])
"""standard deviations of a block's change around a guess, m and rad."""
FOUND = np.array([0.01, 0.01, 0.006, 0.0, 0.0, 0.25])
"""the same around a place where a lost block may lie."""
ENOUGH = np.array([0.0003, 0.0003, 0.0003, 0.004, 0.004, 0.004])
"""standard deviations at which a search ends: a tenth of what is asked of it."""
UPRIGHT = np.array([1, 1, 1, 0, 0, 1.0])
"""what can change of a block that lies flat."""
CALMER = 0.7
"""a frame, by which the spread around guesses shrinks after a surprise."""
SEARCH = 0.12
"""m around a block's last place in which its pixels are looked for."""
FEWEST = 12
"""pixels that show a block, below which it is lost."""
VISIBLE, AGREEING = 0.1, 0.6
"""least share of a block's outline that shows it, and of its pixels that agree, of the usual share."""
SURE = 12
"""frames at rest after which a block is only looked at, but in every `SELDOM`-th frame."""
SELDOM = 5
SOLID = 0.7
"""share of its pixels that must agree with a box in the first frame, else its surface is followed instead."""
HALF, PROOF = 0.5, 12.0
"""share of a resting block's outline below which a movement needs proof: log-likelihood that it gains."""
UNHIDDEN = 0.1
"""share of an outline that may speak against a block that is hidden there."""
TOUCH = 0.015
"""m between the hand's tool-centre point and a block that it may move."""
LOW, LEANING = 0.006, 0.05
"""m above the table or another block and rad of lean, up to which a block lies flat."""


@dataclass(frozen=True)
class Motion:
    """The hand's (7,) pose in the last frame and in this one."""

    before: Array
    now: Array


@dataclass(frozen=True)
class Sight:
    """A pose (7,), and 0…1 how well the pixels bear it out; None where the body was not seen."""

    pose: Array | None
    confidence: float


UNSEEN = Sight(None, 0.0)


@dataclass(frozen=True)
class _Guess:
    """A pose (7,) and how the evidence agrees with it."""

    pose: Array
    fit: Fit
    evidence: BoxEvidence | SurfaceEvidence


class BlockTracker:
    """Follows one block of known size, by its hue where it has one, else by depth alone.

    ``surface`` (S, 3) are points on it in its own frame, for one that turns out to be no box. With ``sought``
    the block's pose is but what it is thought to look like, and it is looked for over the whole table.
    """

    def __init__(
        self, block: Block, hue: str | None, surface: Array, settings: Perception, sought: bool = False
    ) -> None:
        self._hue, self._size, self._pose = hue, block.size, np.array(block.pose)
        self._settings = settings
        self._reach = float(np.linalg.norm(block.size)) / 2 + 0.012
        self._velocity = np.zeros(3)
        self._usual = Usual()
        self._surface: Array | None = None
        self._points = surface[:: 1 + len(surface) // POINTS]
        self._time: float | None = None
        self._shown = np.zeros(3)  # the middle of its visible pixels, from its centre
        self._lost, self._flat = sought, not sought
        self._surprise = AT_REST
        self._rest = Rest()

    @property
    def hue(self) -> str | None:
        """The hue that it is followed by."""
        return self._hue

    @property
    def is_lost(self) -> bool:
        """Whether it was not seen in the last frame."""
        return self._lost

    def nearness(self, pixels: Pixels) -> Float:
        """(M,) one over the depth of its surface where it is."""
        return np.asarray(box_nearness(pixels.origin, pixels.rays, places(self._pose[None]), self._size)[0])

    def follow(
        self, view: View, others: Sequence[Body], hand: Motion | None, generator: np.random.Generator
    ) -> Sight:
        """Where the block is in this frame.

        Args:
            view: the frame.
            others: the hand and the other blocks, which hide pixels.
            hand: how the hand moved; None where it was not seen twice in a row.
            generator: of every draw.
        """
        others = [other for other in others if other is not self]
        guesses = self._guesses(view.frame.t, hand)
        if self._time is None and self._lost:
            return self._find(view, others, guesses, generator)
        if self._time is None:
            self._choose_shape(view, others)
        evidence = self._look(view, self._pose[:3] + guesses[:, :3], others)
        seldom = view.number % SELDOM == 0
        best = (None if seldom else self._unmoved(evidence)) or self._narrow(evidence, guesses, generator)
        if self._lost or self._usual.is_worse(best.fit.score):
            best = self._wide(view, best, guesses, others, generator)
        if self._lost and not self._is_shown(best.fit):
            best = self._anywhere(view, others, generator) or best
        if not self._is_shown(best.fit):
            return self._lose(guesses)
        best = self._stayed(best) or best
        self._accept(best, guesses, view.frame.t)
        return Sight(np.array(self._pose), self._confidence(best.fit))

    def is_covered_at(self, view: View, others: Sequence[Body], pose: Array) -> bool:
        """Whether all that would be seen of the block at ``pose`` (7,) is hidden, nothing against it."""
        others = [other for other in others if other is not self]
        fit = self._look(view, pose[None, :3], others).fit(pose)
        return fit.against + fit.missed <= UNHIDDEN * (fit.shown + fit.against + fit.hidden)

    def lie(self, blocks: Sequence[BlockTracker]) -> None:
        """Rights the block where it leans little and stands on the table or on another of the blocks."""
        angle, turn = tilt(self._pose)
        bottom = self._pose[2] - half_height(self._pose, self._size)
        tops = [
            b._pose[2] + half_height(b._pose, b._size) for b in blocks if b is not self and b._is_under(self)
        ]
        self._flat = angle < LEANING and min(abs(bottom - top) for top in [0.0, *tops]) < LOW
        if self._flat:
            self._pose[3:] = quaternion_multiply(turn, self._pose[3:])

    def _is_under(self, other: BlockTracker) -> bool:
        reach = (np.linalg.norm(self._size) + np.linalg.norm(other._size)) / 2
        apart = other._pose[:3] - self._pose[:3]
        return not self._lost and apart[2] > 0 and bool(np.linalg.norm(apart[:2]) < reach)

    def _choose_shape(self, view: View, others: Sequence[Body]) -> None:
        """A box, unless the first frame shows something else where the first view found it."""
        self._surface = None
        if self._look(view, self._pose[None, :3], others).fit(self._pose).agreement < SOLID:
            self._surface = self._points

    def _look(self, view: View, places: Array, others: Sequence[Body]) -> BoxEvidence | SurfaceEvidence:
        noise = self._settings.depth_noise
        if self._surface is None:
            pixels = view.around(places, self._reach, self._settings.pixels)
            return BoxEvidence(evidence_for(self._hue, pixels, others, noise), self._size)
        window = view.window(places, self._reach)
        seen = evidence_for(self._hue, view.pixels(window), others, noise)
        return SurfaceEvidence(view, window, seen, self._surface, noise)

    def _guesses(self, t: float, hand: Motion | None) -> Array:
        """(G, 6) changes since the last frame: none, going on as before, and, where it may, with the hand."""
        guesses = np.zeros((2, 6))
        if self._time is not None:
            guesses[1, :3] = self._velocity * (t - self._time)
        if hand is None or not (self._lost or self._is_touched(hand.before)):
            return guesses
        carried = compose(compose(hand.now, inverse(hand.before)), self._pose)
        turn = Rotation.from_quat(quaternion_multiply(carried[3:], conjugate(self._pose[3:])))
        with_hand = np.concatenate([carried[:3] - self._pose[:3], turn.as_rotvec()])
        return np.concatenate([guesses, with_hand[None]])

    def _is_touched(self, hand: Array) -> bool:
        inside = rotate(conjugate(self._pose[3:]), hand[:3] - self._pose[:3])
        return bool(np.all(np.abs(inside) < self._size / 2 + TOUCH))

    def _unmoved(self, evidence: BoxEvidence | SurfaceEvidence) -> _Guess | None:
        """The resting block where it is, if its pixels still agree with that."""
        if self._lost or self._rest.frames < SURE:
            return None
        here = _Guess(self._pose, evidence.fit(self._pose), evidence)
        return here if not self._usual.is_worse(here.fit.score) else None

    def _stayed(self, best: _Guess) -> _Guess | None:
        """The block where it rested, if it is half hidden and the rest of it hardly speaks for a movement."""
        if self._lost or self._rest.frames < SURE or best.fit.visible > HALF:
            return None
        here = _Guess(self._pose, best.evidence.fit(self._pose), best.evidence)
        gain = (best.fit.score - here.fit.score) * best.evidence.count
        return here if gain < PROOF and self._is_shown(here.fit) else None

    def _narrow(
        self, evidence: BoxEvidence | SurfaceEvidence, guesses: Array, generator: np.random.Generator
    ) -> _Guess:
        share = max(1 / 3, float(np.max(self._surprise / MOVING)))
        spread = self._surprise * UPRIGHT if self._flat else self._surprise
        return self._search(evidence, self._pose, guesses, spread, share, generator)

    def _search(
        self,
        evidence: BoxEvidence | SurfaceEvidence,
        base: Array,
        guesses: Array,
        spread: Array,
        share: float,
        generator: np.random.Generator,
    ) -> _Guess:
        """The best around changes (G, 6) of a base pose, of a share of the particles."""

        def score(changes: Array) -> Float:
            seen = evidence.score(guessed(base, changes))
            return np.asarray(seen + expected(changes, guesses, 3 * spread), np.float32)

        particles = around(guesses, spread, round(share * self._settings.particles), generator)
        best = anneal(particles, score, self._settings.layers, generator, ENOUGH)
        pose = normalised(moved(base, best.mean[None])[0])
        return _Guess(pose, evidence.fit(pose), evidence)

    def _wide(
        self,
        view: View,
        best: _Guess,
        guesses: Array,
        others: Sequence[Body],
        generator: np.random.Generator,
    ) -> _Guess:
        """The best of a search far around the guesses and around where the block's pixels have gone."""
        seen = view.around(self._pose[None, :3], SEARCH, 3 * self._settings.pixels)
        own = evidence_for(self._hue, seen, others, self._settings.depth_noise).points()
        if len(own) >= FEWEST:
            gone = np.zeros((1, 6))
            gone[0, :3] = np.median(own, axis=0) - self._pose[:3] - self._shown
            guesses = np.concatenate([guesses, gone])
        evidence = self._look(view, self._pose[:3] + guesses[:, :3], others)
        if evidence.count < FEWEST:
            return best
        found = self._search(evidence, self._pose, guesses, MOVING, 1.0, generator)
        same = _Guess(best.pose, evidence.fit(best.pose), evidence)
        return max(same, found, key=lambda guess: guess.fit.score)

    def _anywhere(self, view: View, others: Sequence[Body], generator: np.random.Generator) -> _Guess | None:
        """The lost block, lying flat somewhere on the table where pixels could show it."""
        found = []
        for middle in patches(view, self._hue, others, self._settings.depth_noise):
            pose = flat(self._pose)
            pose[:3] = middle - [0, 0, self._size.min() / 4]  # most of what is seen is its top
            evidence = self._look(view, pose[None, :3], others)
            found.append(self._search(evidence, pose, YAWS, FOUND, 2.0, generator))
        if not found:
            return None
        best = max(found, key=lambda guess: guess.fit.shown * guess.fit.agreement)
        evidence = self._look(view, best.pose[None, :3], others)
        return self._search(evidence, best.pose, np.zeros((1, 6)), MOVING, 1.0, generator)

    def _find(
        self, view: View, others: Sequence[Body], guesses: Array, generator: np.random.Generator
    ) -> Sight:
        """The block that was never seen before."""
        best = self._anywhere(view, others, generator)
        if best is None or best.fit.agreement < SOLID or not self._is_shown(best.fit):
            return UNSEEN
        self._accept(best, guesses, view.frame.t)
        return Sight(np.array(self._pose), self._confidence(best.fit))

    def _is_shown(self, fit: Fit) -> bool:
        agreeing = self._usual.relative(fit.agreement) >= AGREEING
        return fit.shown >= FEWEST and fit.visible >= VISIBLE and agreeing

    def _confidence(self, fit: Fit) -> float:
        return self._usual.relative(fit.agreement) * min(1.0, fit.visible / 0.3)

    def _lose(self, guesses: Array) -> Sight:
        """Not seen: thought to be with the hand if it moved with it, else where it was, until it is found."""
        if len(guesses) > 2 and (self._lost or not self._rest.frames):
            self._pose = normalised(moved(self._pose, guesses[2:])[0])
        self._lost, self._flat, self._rest, self._velocity = True, False, Rest(), np.zeros(3)
        self._surprise = MOVING
        return UNSEEN

    def _accept(self, best: _Guess, guesses: Array, t: float) -> None:
        before, pose = self._pose, best.pose
        if self._lost:
            pose = nearest_alike(pose, self._size, before)
            self._rest = Rest()
        elif pose is not before:
            off = np.linalg.norm(pose[:3] - before[:3] - guesses[:, :3], axis=1).min()
            self._surprise = np.clip(
                MOVING * off / MOVING[0], np.maximum(AT_REST, CALMER * self._surprise), MOVING
            )
            pose = self._rest.settled(before, pose)
        going = self._time is not None and t > self._time and not (self._lost or self._rest.frames)
        self._velocity = (pose[:3] - before[:3]) / (t - (self._time or 0.0)) if going else np.zeros(3)
        self._usual.learn(best.fit.score, best.fit.agreement)
        points = best.evidence.points()
        self._shown = np.median(points, axis=0) - pose[:3] if len(points) else self._shown
        self._pose, self._time, self._lost = np.array(pose), t, False
