"""Fisher information against finite differences, a Monte-Carlo of least squares, and physics.md."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import QuadraticDrag, RollingResistance, ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.information import (
    WrenchNoise,
    fisher_information,
    least_known,
    parameter_regressor,
    phi_covariance,
    phi_scales,
    reduced_noise,
)
from cartgrasp.model import CartModel

NOISE = WrenchNoise(force=3.0, moment=0.1, rate=100.0)
PLAIN = CartModel(Inertia(20.0, (0.3, 0.0), 2.0))


def weaving(u=(0.4, 0.2, 2.0), r=(0.4, 0.5), duration=20.0):
    """(T, 5) states and (T, 2) accelerations of u = u0 + u1 sin(w t), r = r1 sin(w t), sampled at 100 Hz."""
    t = np.arange(0.0, duration, 0.01)
    velocity = np.stack([u[0] + u[1] * np.sin(u[2] * t), r[0] * np.sin(r[1] * t)], axis=-1)
    acceleration = np.stack([u[1] * u[2] * np.cos(u[2] * t), r[0] * r[1] * np.cos(r[1] * t)], axis=-1)
    return np.concatenate([np.zeros((len(t), 3)), velocity], axis=-1), acceleration


def information(cart, states, accelerations, points, noise=NOISE):
    return fisher_information(parameter_regressor(cart, states, accelerations), reduced_noise(cart, points, noise))


def standard_deviations(information):
    """Cramér-Rao bounds (p,); infinite for what a direction that nothing teaches is a part of."""
    blind = np.abs(null_space(information, rcond=1e-12)).max(axis=1, initial=0.0) > 1e-6
    return np.where(blind, np.inf, np.sqrt(np.diag(np.linalg.pinv(information, rcond=1e-12, hermitian=True))))


@pytest.mark.parametrize(("px", "figure"), [(0.0, 0.019), (-0.5, 0.265), (-1.0, 0.448)])
def test_figures_of_physics_13(px, figure):
    """3 N and 0.1 N·m at 100 Hz for 20 s, u = 0.4 + 0.2 sin 2t, r = 0.4 sin 0.5t, all of phi unknown."""
    sd = standard_deviations(information(PLAIN, *weaving(), [(px, 0.0, 1.0)]))[1]
    assert sd == pytest.approx(figure, rel=0.02)


def test_law_of_the_lever():
    """With u and r constant and the rest known, m dx enters fx by -r² and the moment by u r."""
    u, r, n = 0.5, 0.4, 300
    states = np.tile([0.0, 0.0, 0.0, u, r], (n, 1))
    for px in (0.0, -0.3, 0.7):
        found = information(PLAIN, states, np.zeros((n, 2)), [(px, 0.0, 1.0)])[1, 1]
        assert found == pytest.approx(n * ((u * r) ** 2 / (0.1**2 + (3.0 * px) ** 2) + r**4 / 3.0**2))


@given(st.integers(0, 2), st.floats(-0.4, 0.4), st.integers(0, 2**32 - 1))
def test_regressor_is_the_slope_of_the_required_wrench(rows, axle, seed):
    rng = np.random.default_rng(seed)
    constraints = RollingConstraints(None if rows == 0 else axle, no_rotation=rows == 2)
    effects = (ViscousDrag(3.0, 1.2), RollingResistance(0.02), QuadraticDrag(1.5))
    cart = CartModel(Inertia(20.0, (0.3, 0.1), 2.0), constraints, effects)
    k = constraints.n_free
    states = np.concatenate([rng.uniform(-1, 1, (5, 3)), rng.uniform(0.1, 1.0, (5, k))], axis=-1)
    accelerations = rng.uniform(-1, 1, (5, k))
    found = parameter_regressor(cart, states, accelerations)
    for j, value in enumerate(cart.parameters):
        step = 1e-5 * max(1.0, abs(value)) * np.eye(len(cart.parameters))[j]
        ends = [cart.required_wrench(states, accelerations, cart.parameters + s * step) for s in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step[j])
        assert np.allclose(found[..., j], slope, rtol=1e-6, atol=1e-6)


@given(st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_noise_of_the_sum_by_hand(n_arms, seed):
    """Against moments taken by hand: tau = sum x fy - y fx + tz in the arms' turned frames."""
    rng = np.random.default_rng(seed)
    points, yaws = rng.uniform(-1, 1, (n_arms, 3)), rng.uniform(-1, 1, n_arms)
    found = reduced_noise(PLAIN, points, NOISE, yaws)
    maps = []
    for (x, y, _), yaw in zip(points, yaws, strict=True):
        ahead, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        maps.append([[3 * ahead[0], 3 * left[0], 0.0], [3 * (x * v[1] - y * v[0]) for v in (ahead, left)] + [0.1]])
    assert np.allclose(found, sum(np.array(m) @ np.array(m).T for m in maps))


def test_monte_carlo_of_least_squares():
    """400 weighted fits of noisy recorded wrenches of two arms: their scatter is the bound, within 4 sigma."""
    cart = CartModel(Inertia(20.0, (0.3, 0.1), 2.0), effects=(ViscousDrag(3.0, 1.2),))
    states, accelerations = weaving(duration=8.0)
    points, n_runs, rng = np.array([(-0.25, 0.2, 1.0), (0.1, -0.3, 1.0)]), 400, np.random.default_rng(4)
    exact = cart.required_wrench(states, accelerations)
    recorded = np.tile(exact, (n_runs, 1, 1))
    for x, y, _ in points:
        force = 3.0 * rng.standard_normal((n_runs, len(states), 2))
        moment = 0.1 * rng.standard_normal((n_runs, len(states)))
        recorded += np.stack([force[..., 0], x * force[..., 1] - y * force[..., 0] + moment], axis=-1)
    columns = [
        cart.required_wrench(states, accelerations, cart.parameters + unit) - exact
        for unit in np.eye(len(cart.parameters))
    ]
    root = np.linalg.inv(np.linalg.cholesky(reduced_noise(cart, points, NOISE)))
    design = np.einsum("ij,ptj->tip", root, np.array(columns)).reshape(-1, len(columns))
    values = np.einsum("ij,rtj->rti", root, recorded - exact).reshape(n_runs, -1)
    fits = np.linalg.lstsq(design, values.T, rcond=None)[0]
    bound = standard_deviations(information(cart, states, accelerations, points))
    assert np.allclose(fits.std(axis=1), bound, rtol=4 / np.sqrt(2 * n_runs))
    correlation = np.linalg.inv(information(cart, states, accelerations, points)) / np.outer(bound, bound)
    assert np.allclose(np.corrcoef(fits), correlation, atol=4 / np.sqrt(n_runs))


def test_what_a_straight_line_can_teach():
    """Only m and m dy; at constant speed nothing; turning with speed, all four (physics.md)."""
    states, accelerations = weaving(r=(0.0, 1.0))
    straight = standard_deviations(information(PLAIN, states, accelerations, [(-0.25, 0.0, 1.0)]))
    assert np.isfinite(straight[[0, 2]]).all()
    assert np.isinf(straight[[1, 3]]).all()
    steady = information(PLAIN, np.tile([0, 0, 0, 0.5, 0.0], (9, 1)), np.zeros((9, 2)), [(-0.25, 0.0, 1.0)])
    assert not steady.any()
    assert np.isfinite(standard_deviations(information(PLAIN, *weaving(), [(-0.25, 0.0, 1.0)]))).all()


def test_least_known_direction():
    """After a straight drive, it lies in the plane of m dx and J, at the prior's size."""
    states, accelerations = weaving(r=(0.0, 1.0))
    scales = phi_scales(PLAIN.inertia.phi)
    prior = np.diag(1.0 / np.array([8.0, 4.0, 4.0, 2.0]) ** 2)
    total = prior + information(PLAIN, states, accelerations, [(-0.25, 0.0, 1.0)])
    size, direction = least_known(total, scales)
    assert np.abs(direction[[0, 2]]).max() < 1e-6
    assert size == pytest.approx(max(4.0 / scales[1], 2.0 / scales[3]))
    assert np.allclose(phi_covariance(total), np.linalg.inv(total))


@pytest.mark.parametrize("wrong", [{"force": -1.0}, {"moment": np.nan}, {"rate": 0.0}])
def test_noise_that_can_not_be(wrong):
    with pytest.raises(UsageError, match="wrench noise"):
        WrenchNoise(**wrong)
