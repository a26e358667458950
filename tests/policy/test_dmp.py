"""A movement primitive is linear in its weights, reaches its goal, and imitates what it is shown."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from imitate.geometry import align_signs, resample
from imitate.policy.dmp import imitate, response, rollout, scaling

SAMPLES, KERNELS, DECAY, STIFFNESS = 300, 30, 4.6, 50.0
weights = arrays(float, (KERNELS, 3), elements=st.floats(-5, 5))
points = arrays(float, 3, elements=st.floats(-1, 1))


@pytest.fixture(scope="module")
def shape():
    return response(SAMPLES, KERNELS, DECAY, STIFFNESS)


def integrated(start, goal, weights, shape):
    """Hoffmann's equation by explicit Euler, step by step, as the paper writes it."""
    dt, alpha, beta = 1 / (SAMPLES - 1), STIFFNESS, STIFFNESS / 4
    y, z, path = np.array(start, float), np.zeros(3), []
    for x, psi in zip(shape.phase, shape.activations, strict=True):
        path.append(y)
        f = x * (psi @ weights)
        pull = alpha * (beta * (goal - y) - z) - alpha * beta * (goal - start) * x + alpha * beta * f
        y, z = y + dt * z, z + dt * pull
    return np.array(path)


@given(start=points, goal=points, w=weights)
def test_response_is_the_integrated_equation(shape, start, goal, w):
    assert np.allclose(rollout(shape, start, goal, w), integrated(start, goal, w, shape), atol=1e-9)


@given(a=weights, b=weights)
def test_linear_in_the_weights(shape, a, b):
    zero = np.zeros(3)
    both = rollout(shape, zero, zero, a + b)
    assert np.allclose(both, rollout(shape, zero, zero, a) + rollout(shape, zero, zero, b), atol=1e-9)


@given(start=points, goal=points)
def test_without_weights_it_ends_at_the_goal_within_the_response(shape, start, goal):
    end = rollout(shape, start, goal, np.zeros((KERNELS, 3)))[-1]
    assert np.allclose(end, start + shape.goal[-1] * (goal - start), atol=1e-12)
    assert abs(shape.goal[-1] - 1) < 0.02


@given(w=weights)
def test_it_starts_at_rest_where_it_is_told(shape, w):
    path = rollout(shape, np.ones(3), np.zeros(3), w)
    assert np.allclose(path[:2], 1.0)


def test_imitation_follows_a_person_within_a_millimetre(human_stack):
    t = human_stack.t - human_stack.t[0]
    at = np.arange(8.45, t[-1], 1 / 60)
    hand = align_signs(resample(t, human_stack.hand, at))
    shape = response(len(at), KERNELS, DECAY, STIFFNESS)
    path = rollout(shape, hand[0], hand[-1], imitate(shape, hand, hand[-1]))
    rmse = np.sqrt(np.mean(np.sum((path - hand)[:, :3] ** 2, axis=1)))
    assert rmse < 1e-3


def test_noise_of_all_kernels_alike_is_only_the_most_active_share(shape):
    # Each time one kernel acts, with less than all of the activation.
    assert np.all(shape.noise.sum(axis=1) <= shape.kernels.sum(axis=1) + 1e-12)
    assert shape.noise[-1].sum() > 0


@pytest.mark.parametrize("decay", [0.0, DECAY])
def test_each_kernel_is_as_wide_as_the_way_to_the_next_and_the_last_as_that_to_it(decay):
    shape = response(101, 5, decay, STIFFNESS)
    centres = [np.exp(-decay * t) if decay else 1 - t for t in (0, 0.25, 0.5, 0.75, 1)]
    ways = [before - after for before, after in pairwise(centres)]
    psi = np.array(
        [
            [np.exp(-(((x - c) / way) ** 2) / 2) for c, way in zip(centres, [*ways, ways[-1]], strict=True)]
            for x in shape.phase
        ]
    )
    np.testing.assert_allclose(shape.activations, psi / psi.sum(axis=1)[:, None], rtol=1e-9)


def test_a_phase_without_decay_falls_evenly_to_zero():
    phase = response(101, 5, 0.0, STIFFNESS).phase
    assert np.allclose(phase, np.linspace(1, 0, 101))


def test_a_force_with_an_even_phase_falls_evenly_behind_it():
    # A critically damped spring follows a ramp with a delay of 1/β = 4/α.
    shape = response(300, 5, 0.0, STIFFNESS)
    force = rollout(shape, np.zeros(1), np.zeros(1), np.full((5, 1), 30.0))[:, 0]
    assert force[150:] == pytest.approx(30 * (shape.phase[150:] + 4 / STIFFNESS), rel=0.02)


def test_the_original_form_reaches_its_goal_and_scales_the_movement():
    original = response(SAMPLES, KERNELS, DECAY, STIFFNESS, original=True)
    rng = np.random.default_rng(0)
    w, start = rng.normal(0, 0.2, (KERNELS, 1)), np.zeros(1)
    one = rollout(original, start, np.ones(1), w)
    twice = rollout(original, start, np.full(1, 2.0), scaling(start, np.full(1, 2.0), np.ones(1)) * w)
    np.testing.assert_allclose(twice, 2 * one)
    assert one[-1, 0] == pytest.approx(1, abs=0.05)


def test_the_original_form_turns_the_movement_round_where_hoffmanns_does_not(shape):
    shown = np.linspace(0, 0.1, SAMPLES)[:, None] + 0.2 * np.sin(np.linspace(0, np.pi, SAMPLES))[:, None]
    original = response(SAMPLES, KERNELS, DECAY, STIFFNESS, original=True)
    goal = np.array([-0.1])
    w = imitate(original, shown, shown[-1])
    inverted = rollout(original, shown[0], goal, scaling(shown[0], goal, shown[-1] - shown[0]) * w)
    kept = rollout(shape, shown[0], goal, imitate(shape, shown, shown[-1]))
    bump = kept[:, 0] - np.linspace(0, -0.1, SAMPLES)
    assert inverted.min() < -0.15
    assert bump.max() > 0.1
    assert bump.min() > -0.03


def test_the_original_forms_scale_is_one_where_nothing_was_shown_to_move():
    assert scaling(np.zeros(2), np.array([0.3, 0.2]), np.array([0.0, 0.1])).tolist() == [1.0, 2.0]


@pytest.mark.parametrize("original", [False, True])
@given(w=weights, start=points, goal=points)
def test_for_any_weights_the_goal_is_approached_as_time_goes_on(original, w, start, goal):
    # Unit duration first, then twenty more in which the phase has died out.
    long = response(21 * SAMPLES, KERNELS, 21 * DECAY, 21 * STIFFNESS, original)
    assert np.allclose(rollout(long, start, goal, w)[-1], goal, atol=1e-6)


@pytest.mark.parametrize("original", [False, True])
@given(w=weights, start=points, goal=points)
def test_at_its_end_the_goal_is_missed_by_no_more_than_the_response_says(original, w, start, goal):
    shape = response(SAMPLES, KERNELS, DECAY, STIFFNESS, original)
    scale = scaling(start, goal, np.full(3, 0.1)) if original else np.ones(3)
    end = rollout(shape, start, goal, scale * w)[-1]
    most = np.abs(shape.kernels[-1]).sum() * np.abs(scale * w).max(axis=0)
    assert np.all(np.abs(end - goal) <= abs(1 - shape.goal[-1]) * np.abs(goal - start) + most + 1e-12)
    assert abs(1 - shape.goal[-1]) < 0.02
    assert np.abs(shape.kernels[-1]).sum() < 0.03  # of a unit weight, what is left at the end


@pytest.mark.parametrize("original", [False, True])
@given(w=weights, start=points, goal=points)
def test_time_scales_nothing_else(original, w, start, goal):
    # The same path at proportional times: what differs is Euler's error, which halves with the step.
    coarse, fine, finer = (
        rollout(response(2**k * (SAMPLES - 1) + 1, KERNELS, DECAY, STIFFNESS, original), start, goal, w)[
            :: 2**k
        ]
        for k in range(3)
    )
    first, second = np.abs(fine - coarse).max(), np.abs(finer - fine).max()
    extent = np.abs(coarse - start).max() + np.abs(w).max()
    assert first <= 0.02 * extent + 1e-9
    assert second <= 0.75 * first + 1e-9
