"""What a motion can show: against two columns whose angle is known, and on a log."""

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy.findings.isolability import compared, isolability
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances

from ...runs import integrate, pushed_straight, record, weave

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.2, 0.0), 2.0), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def of(columns, effects, base):
    ends = np.cumsum([size for _, size in effects])
    traces = [(key, columns[:, end - size : end]) for (key, size), end in zip(effects, ends, strict=True)]
    return compared(base, np.full(base.shape[1], 1e-9), traces)


@pytest.mark.parametrize(("angle", "alike"), [(0.1, True), (1.2, False)])
def test_parallel_traces_are_alike(angle, alike):
    random = np.random.default_rng(0)
    first, other = np.linalg.qr(random.standard_normal((50, 2)))[0].T
    columns = 5 * np.column_stack([first, np.cos(angle) * first + np.sin(angle) * other])
    base = random.standard_normal((50, 1))
    base -= np.outer(np.outer(first, first) @ base + np.outer(other, other) @ base, [1.0])
    found = of(columns, [("rolling_resistance", 1), ("quadratic_drag", 1)], base)
    assert (found["rolling_resistance"].alike == ("quadratic_drag",)) == alike
    assert found["rolling_resistance"].z == pytest.approx(5.0)
    assert found["rolling_resistance"].is_shown
    assert found["rolling_resistance"].likeness["quadratic_drag"] == pytest.approx(np.cos(angle))
    assert found["quadratic_drag"].likeness == {"rolling_resistance": pytest.approx(np.cos(angle))}


def test_what_the_base_explains_is_not_shown():
    random = np.random.default_rng(1)
    base = random.standard_normal((50, 2))
    columns = np.column_stack([base @ [0.3, -1.0], random.standard_normal(50)])
    found = of(columns, [("rolling_resistance", 1), ("quadratic_drag", 1)], base)
    assert not found["rolling_resistance"].is_shown
    assert found["quadratic_drag"].is_shown


def test_an_effect_with_two_amplitudes_is_like_one_in_its_plane():
    random = np.random.default_rng(2)
    plane = 4 * random.standard_normal((50, 2))
    columns = np.column_stack([plane, plane @ [1.0, -0.5]])
    found = of(columns, [("floor_slope", 2), ("rolling_resistance", 1)], random.standard_normal((50, 1)))
    assert found["rolling_resistance"].alike == ("floor_slope",)


def model(weaves):
    truth, wrenches = integrate(TRUTH, weave if weaves else pushed_straight, 24.0)
    wrench = np.zeros((len(truth), 6))
    wrench[:, 0], wrench[:, 5] = wrenches.T
    log = record(truth, {"hand": (np.array([-0.4, 0.0, 1.0]), wrench)}, (0.0004, 0.004, 1.0), 3)
    return Model.started([Balances.of(log, CART)], CART)


@pytest.mark.long
def test_on_a_straight_way_a_slope_is_a_biased_sensor():
    """One heading alone: what gravity does along it and what the sensor adds to the forward force are one constant.
    With many headings they are not."""
    straight, many = isolability(model(weaves=False)), isolability(model(weaves=True))
    assert straight["floor_slope"].likeness["force_bias"] > 0.99
    assert "force_bias" not in many["floor_slope"].alike
    assert many["floor_slope"].is_shown
    assert many["floor_slope"].likeness["force_bias"] == many["force_bias"].likeness["floor_slope"]
    assert not {"viscous_drag", "time_delay", "payload_change", "external_push", "floor_patch"} & set(many)
    assert {"wheel_misalignment", "lateral_slip", "load_slosh"} <= set(many)
