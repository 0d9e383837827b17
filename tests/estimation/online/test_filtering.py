"""Predict and update against matrix exponentials, exact solutions, and the batch solution."""

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from estimation.gaussian import Gaussian, normalised_square

from .reference_filtering import exponential_step, innovation, predicted, transition, updated

entries = st.floats(-3, 3, allow_nan=False, allow_infinity=False)
matrices = hnp.arrays(np.float64, (4, 4), elements=entries)
steps = st.floats(1e-4, 0.05)


def covariance_of(root):
    return root @ root.T + 0.01 * np.eye(len(root))


@given(matrices, st.floats(1e-4, 0.5))
def test_transition_is_the_matrix_exponential(matrix, step):
    expected = scipy.linalg.expm(matrix * step)
    np.testing.assert_allclose(transition(matrix, step), expected, rtol=2e-4, atol=2e-4 * np.abs(expected).max())


def test_a_stiff_decay_stays_a_decay():
    result = transition(np.diag([-5000.0, -1.0]), 0.01)
    assert 0 <= result[0, 0] < 1e-6
    assert result[1, 1] == pytest.approx(np.exp(-0.01), rel=1e-6)


@given(matrices, hnp.arrays(np.float64, 4, elements=entries), matrices, steps)
def test_step_against_exact_integrals(jacobian, rate, root, step):
    density = covariance_of(root)
    got = exponential_step(rate, jacobian, density, step)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    times = step * (nodes + 1) / 2
    flows = [scipy.linalg.expm(jacobian * t) for t in times]
    increment = sum(step / 2 * w * f @ rate for w, f in zip(weights, flows, strict=True))
    noise = sum(step / 2 * w * f @ density @ f.T for w, f in zip(weights, flows, strict=True))
    np.testing.assert_allclose(got.increment, increment, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(got.noise, noise, rtol=1e-3, atol=1e-4 * np.abs(noise).max())
    assert np.linalg.eigvalsh(got.noise).min() >= -1e-12


def test_predicted_adds_what_the_step_says():
    prior = Gaussian(np.array([1.0, 2.0]), np.diag([1.0, 4.0]))
    step = exponential_step(np.array([2.0, 0.0]), np.array([[0.0, 1.0], [0.0, 0.0]]), np.zeros((2, 2)), 0.1)
    after = predicted(prior, step)
    np.testing.assert_allclose(after.mean, [1.2, 2.0], atol=1e-12)
    np.testing.assert_allclose(after.covariance, [[1.04, 0.4], [0.4, 4.0]], atol=1e-12)


@given(matrices, hnp.arrays(np.float64, (2, 4), elements=entries), hnp.arrays(np.float64, 2, elements=entries))
def test_update_is_the_weighted_least_squares_solution(root, H, residual):
    prior, R = Gaussian(np.array([1.0, -1.0, 0.5, 0.0]), covariance_of(root)), np.diag([0.5, 0.2])
    after = updated(prior, innovation(prior, residual, H, R), H, R)
    information = np.linalg.inv(prior.covariance) + H.T @ np.linalg.solve(R, H)
    step = np.linalg.solve(information, H.T @ np.linalg.solve(R, residual))
    np.testing.assert_allclose(after.mean, prior.mean + step, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(after.covariance, np.linalg.inv(information), rtol=1e-4, atol=1e-6)


def test_update_keeps_a_covariance_sound_where_the_short_form_does_not():
    """A measurement 10^8 times better than the prior: (I - K H) P of (20) loses symmetry or sign, Joseph's does not."""
    prior = Gaussian(np.zeros(2), np.array([[1e8, 1e8], [1e8, 1e8 + 1e-3]]))
    H, R = np.array([[1.0, 0.0]]), np.array([[1e-8]])
    after = prior
    for _ in range(50):
        after = updated(after, innovation(after, np.zeros(1), H, R), H, R)
    assert np.linalg.eigvalsh(after.covariance).min() >= -1e-9
    assert (after.covariance == after.covariance.T).all()


def test_normalised_square_broadcasts():
    difference = np.array([[1.0, 2.0], [0.0, 3.0]])
    covariance = np.diag([1.0, 4.0])
    np.testing.assert_allclose(normalised_square(difference, covariance), [2.0, 2.25])
