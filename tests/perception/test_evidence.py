"""What pixels say about a box: shown, contradicted, hidden, somebody else's."""

import numpy as np
import pytest

from imitate.perception.evidence import BoxEvidence, evidence_for
from imitate.perception.shapes import LIMIT, Pixels, Places, box_nearness, places

SIZE = np.array([0.04, 0.05, 0.06])
HERE = np.array([0.0, 0, 0.03, 0, 0, 0, 1])
BLUE, GREEN = 225, 125
NOISE = 0.003


class Screen:
    """A green body whose nearness is given."""

    hue, is_lost = "green", False

    def __init__(self, near):
        self._near = near

    def nearness(self, _):
        return self._near


def pixels(depth=None, hue=None):
    """What a camera 0.6 m above the table sees of the box lying there."""
    x, y = np.meshgrid(np.linspace(-0.15, 0.15, 61), np.linspace(-0.15, 0.15, 61))
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3).astype(np.float32)
    origin = np.array([0.02, -0.03, 0.6])
    near = box_nearness(origin, rays, places(HERE[None]), SIZE)[0]
    hit = near > 0
    seen = np.where(hit, 1 / np.where(hit, near, 1), 0.6).astype(np.float32)
    paint = np.where(hit, np.float32(BLUE), np.float32(np.nan))
    return hit, Pixels(
        origin, rays, seen if depth is None else depth(seen, hit), paint if hue is None else hue
    )


def shifted(*shifts):
    poses = np.tile(HERE, (len(shifts), 1))
    poses[:, :3] += shifts
    return places(poses)


def test_the_truth_agrees_wholly_and_is_the_best():
    hit, seen = pixels()
    evidence = BoxEvidence(evidence_for("blue", seen, (), NOISE), SIZE)
    fit = evidence.fit(HERE)
    assert fit.agreement == 1 and fit.visible == 1 and fit.shown > 0.9 * hit.sum()
    scores = evidence.score(shifted([0, 0, 0], [0.01, 0, 0], [0, -0.01, 0], [0, 0, 0.012], [0, 0, -0.012]))
    assert scores[0] == pytest.approx(0, abs=1e-3) and np.all(scores[1:] < -5 * LIMIT)


def test_what_is_nearer_hides_and_what_is_farther_contradicts():
    def fence(offset):
        return lambda seen, hit: np.where(hit & (np.arange(len(hit)) % 2 == 0), seen + offset, seen)

    hit, _ = pixels()
    for offset, name in ((-0.2, "hidden"), (0.1, "against")):
        _, seen = pixels(lambda s, h, o=offset: fence(o)(s, h).astype(np.float32))
        own = np.where(hit & (np.arange(len(hit)) % 2 == 1), np.float32(BLUE), np.float32(np.nan))
        fenced = Pixels(seen.origin, seen.rays, seen.depth, own)
        fit = BoxEvidence(evidence_for("blue", fenced, (), NOISE), SIZE).fit(HERE)
        assert getattr(fit, name) == pytest.approx(hit.sum() / 2, abs=0.1 * hit.sum())
        assert fit.agreement == pytest.approx(1.0 if name == "hidden" else 0.5, abs=0.05)


def test_another_body_known_to_be_there_counts_neither_way():
    hit, seen = pixels()
    near = np.where(hit, 1 / seen.depth, 0).astype(np.float32)
    green = Pixels(seen.origin, seen.rays, seen.depth, np.where(hit, GREEN, np.nan).astype(np.float32))
    alone = BoxEvidence(evidence_for("blue", green, (), NOISE), SIZE).fit(HERE)
    beside = BoxEvidence(evidence_for("blue", green, (Screen(near),), NOISE), SIZE).fit(HERE)
    assert alone.against > 0.9 * hit.sum() and beside.against == 0
    assert beside.hidden == hit.sum()


def test_the_bodys_colour_on_the_table_is_no_evidence():
    _, seen = pixels()
    grainy = np.where(np.arange(len(seen.hue)) % 3 == 0, np.float32(BLUE), seen.hue)
    speckled = Pixels(seen.origin, seen.rays, seen.depth, grainy)
    assert BoxEvidence(evidence_for("blue", speckled, (), NOISE), SIZE).fit(HERE).agreement == 1


def test_without_colour_depth_alone_tells():
    _, seen = pixels()
    grey = Pixels(seen.origin, seen.rays, seen.depth, np.full_like(seen.hue, np.nan))
    evidence = BoxEvidence(evidence_for(None, grey, (), NOISE), SIZE)
    scores = evidence.score(shifted([0, 0, 0], [0.01, 0, 0], [0, -0.01, 0], [0, 0, 0.012], [0, 0, -0.012]))
    assert scores.argmax() == 0 and evidence.fit(HERE).agreement == 1


def test_many_guesses_are_scored_as_one_by_one():
    _, seen = pixels()
    evidence = BoxEvidence(evidence_for("blue", seen, (), NOISE), SIZE)
    guesses = shifted(*np.random.default_rng(0).normal(0, 0.01, (20, 3)))
    single = [evidence.score(Places(guesses.turned[k : k + 1], guesses.at[k : k + 1]))[0] for k in range(20)]
    np.testing.assert_allclose(evidence.score(guesses), single, rtol=1e-5)
