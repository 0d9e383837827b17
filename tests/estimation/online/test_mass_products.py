"""Belief in products of mass and coefficient: against differences, and against runs that hardly tell the two apart."""

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import FloorSlope, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.studies.estimators import HANDS, SENSOR_SETS, Job, drive_cart
from cartgrasp.studies.scenario import filter_noise
from estimation import CartFilter, FilterNoise
from estimation.gaussian import Gaussian
from estimation.online.kernels.row_algebra import Smoothed, weights
from estimation.online.regressor.filtered_row import Block
from estimation.online.regressor.mass_products import LearnedParameters, MassProducts

from ..runs import wrench_rows
from .declared import filtered_row, unmodelled_noise

CART = CartModel(
    Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(3.0), FloorSlope(0.01, 0.02), RollingResistance(0.02))
)
FREE = np.arange(len(CART.parameters))
PRODUCTS = MassProducts.of(CART, FREE)


def test_products_are_those_of_rolling_resistance_and_slopes():
    names = [CART.parameter_names[i] for i in PRODUCTS.by_mass]
    assert names == ["floor_slope.grade_x", "floor_slope.grade_y", "rolling_resistance.coefficient"]
    assert not len(MassProducts.of(CART, FREE[1:]).by_mass)  # a mass that is given


def test_there_and_back_with_slopes_by_differences():
    theta = CART.parameters
    assert PRODUCTS.factors(PRODUCTS.products(theta)) == pytest.approx(theta)
    at, by = PRODUCTS.products(theta), PRODUCTS.jacobian(theta)
    for i in FREE:
        step = np.zeros(len(theta))
        step[i] = 1e-5
        slope = (PRODUCTS.factors(at + step) - PRODUCTS.factors(at - step)) / 2e-5
        assert by[:, i] == pytest.approx(slope, abs=1e-8)
    assert PRODUCTS.by_factors(theta) @ by == pytest.approx(np.eye(len(theta)), abs=1e-12)
    root = np.diag(np.arange(1.0, 1 + len(theta)))
    belief = PRODUCTS.belief(Gaussian(theta, root @ root), FREE, theta)
    told = PRODUCTS.factors_of(
        LearnedParameters(belief.mean, belief.covariance, np.linalg.cholesky(belief.covariance), 0.0)
    )
    assert told.theta == pytest.approx(theta)
    assert told.covariance == pytest.approx(root @ root)
    assert told.root @ told.root.T == pytest.approx(root @ root)


def test_a_row_is_linear_in_them():
    """On a level CoM line: of a resistance nothing is left out, and a far change is foretold by the slopes."""
    cart = CartModel(Inertia(24.0, (0.28, 0.0), 2.2), effects=(RollingResistance(0.02),))
    products = MassProducts.of(cart, np.arange(5))
    time, zero, exact = 0.015 * np.arange(11), np.zeros((11, 3)), np.tile(1e-12 * np.eye(2), (11, 1, 1))
    velocity, acceleration = np.tile([0.5, 0.0], (11, 1)), np.tile([0.3, 0.0], (11, 1))
    moved = Smoothed(time, zero, velocity, acceleration, exact, exact[:3], *(np.zeros((2, 11, 0))))
    spread = np.zeros((5, 2))
    spread[[0, 4], [0, 1]] = 8.0, 0.01

    def row(theta):
        block = Block(weights(time, 1), moved, wrench_rows(time[:-1], np.zeros((10, 2)), theta))
        known = Gaussian(theta, spread @ spread.T)
        return filtered_row(cart, known, spread, block, unmodelled_noise(cart, FilterNoise(), products.by_mass))

    here, there = cart.parameters, cart.parameters.copy()
    there[[0, 4]] = 60.0, 0.005
    found = row(here)
    assert found.curvature == pytest.approx(0.0, abs=1e-12)
    slopes = products.of_row(found, here).slopes[:, :5]
    change = slopes @ (products.products(there) - products.products(here))
    assert found.residual - row(there).residual == pytest.approx(change, rel=1e-9)


@pytest.mark.prove
def test_neither_is_sure_where_only_their_product_shows():
    """Gentle paths of 14 s, first guesses from half to twice the mass: errors are what is told of them."""
    squares = []
    for seed in range(12):
        random = np.random.default_rng([seed, 21])
        mass, share, off = random.uniform(10, 80), float(np.exp(random.uniform(-0.7, 0.7))), random.uniform(0.5, 2.0)
        truth, believed = (
            CartModel(Inertia(m, (0.3, 0.0), 0.09 * m), RollingConstraints(), (RollingResistance(c),))
            for m, c in ((mass, 0.02), (share * mass, 0.02 * off))
        )
        cart_filter = CartFilter(believed, list(HANDS), noise=filter_noise(SENSOR_SETS["usual"]))
        for measurement in drive_cart(truth, Job("gentle", "usual", seed), 14.0).log.measurements():
            told = cart_filter.update(measurement).parameters["mass"]
        squares.append(((told.value - mass) / told.std) ** 2)
    assert np.sqrt(np.mean(squares)) < 1.5
