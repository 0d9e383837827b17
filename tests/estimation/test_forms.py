"""Other forms of an effect as unknowns: a larger covariance, worked out densely; their sizes, found again."""

import numpy as np
import pytest

from cartgrasp.effects import RollingResistance, ViscousDrag, WheelDragImbalance
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy.evidence import findings
from estimation.discrepancy.fitted import Fitted
from estimation.discrepancy.forms import form_sizes
from estimation.discrepancy.manoeuvres import settled

from .runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


@pytest.fixture(scope="module")
def regression():
    log, _ = simulate(TRUTH, 0, 10.0, noise=(0.0005, 0.005, 3.0))
    return WrenchRegression(log, CART, None)


def test_forms_are_a_larger_covariance(regression):
    """And cost what its determinant does."""
    few = regression.within(np.arange(len(regression.motion.time)) % 8 == 0)
    fitted = Fitted((few,), CART, (RollingResistance(coefficient=0.02),), start=np.append(CART.parameters, 0.02))
    ((own, line, _),) = fitted.linearised
    forms = fitted.forms(own, line)
    n, f, k = forms.columns.shape
    inverse = line.whitened(np.eye(n * f).reshape(n, f, n * f)).reshape(n * f, n * f)
    flat = forms.columns.reshape(n * f, k)
    residual = line.residual.reshape(n * f)
    wide = np.linalg.inv(inverse) + flat @ flat.T
    dense = residual @ np.linalg.solve(wide, residual) + np.linalg.slogdet(wide)[1] + np.linalg.slogdet(inverse)[1]
    assert line.chi_squared - forms.taken(line) == pytest.approx(dense, rel=1e-6)


def test_near_rest_a_moment_may_be_any(regression):
    """Of an effect that turns the cart, in manoeuvres in which it comes to rest; at speed it may not."""
    fitted = Fitted((regression,), CART, (WheelDragImbalance(force=4.0, moment=1.0),))
    ((own, line, _),) = fitted.linearised
    forms = fitted.forms(own, line)
    near_rest = forms.columns[:, :, forms.family == 2]
    slow = ~settled(own)[line.nodes]
    assert slow.any()
    assert not slow.all()
    assert not near_rest[~slow].any()
    assert not near_rest[:, 0].any()
    turned = line.by[:, 1, fitted.free] @ fitted.shares[:, 0]
    np.testing.assert_allclose(near_rest[:, 1].sum(axis=1), slow * turned, atol=1e-12)


def test_what_is_a_form_of_a_known_effect_is_hardly_evidence_for_another(regression):
    fitted = Fitted((regression,), CART, (RollingResistance(coefficient=0.0),))
    wide = Fitted((regression,), CART, (RollingResistance(coefficient=0.05),), start=np.append(CART.parameters, 0.05))
    drag = RollingResistance(label="another")
    known, free = (findings(f.dictionary([drag]), f.loose)[0] for f in (fitted, wide))
    assert free.std[0] > known.std[0]


@pytest.mark.parametrize("size", [0.0, 1.0, 3.0])
def test_sizes_are_found_again(size):
    generator = np.random.default_rng(1)
    columns = generator.standard_normal((400, 30))
    family = np.repeat([0, 1], 15)
    true = np.where(family == 0, size, 0.3) * generator.standard_normal(30)
    information = columns.T @ columns
    pull = columns.T @ (columns @ true + generator.standard_normal(400))
    found = form_sizes(information, pull, family)
    assert found[0] == pytest.approx(size, rel=0.4, abs=0.1)
    assert found[-1] == pytest.approx(0.3, rel=0.5)
