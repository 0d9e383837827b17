"""Logs that were measured: nothing but what is true of them is told, and what is made wrong in them is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.measured.carts import guessed
from benchmarks.measured.logs import LOGS
from cartgrasp.logs import read_log
from cartgrasp.logs.emps import read_emps
from estimation.sensor_check import check_sensors

from .logs import found, with_wrenches

SHARED = Path(__file__).parents[4] / "shared" / "data"
MASS = {"car": 205.0, "wheelchair": 105.0, "emps": 95.1}
"""kg, the middle of what two-way least squares brackets."""
STEPS = {"wheelchair": np.radians(0.09) * 0.3086, "good cart": 0.01, "magnetic bumper": 0.01, "sail": 0.01}
"""m, of encoder and ranger, as the data's README says."""

pytestmark = pytest.mark.skipif(not SHARED.exists(), reason="the measured logs are not here")


def measured(name):
    one = next(log for log in LOGS if log.name == name)
    path = SHARED / one.path
    return (read_emps(path) if path.suffix == ".mat" else read_log(path)), one.cart


@pytest.mark.some(10)
@pytest.mark.long
@pytest.mark.parametrize("name", [log.name for log in LOGS])
@pytest.mark.parametrize("guess", [0.4, 1.0, 2.5])
def test_nothing_but_coarse_steps_is_told(name, guess):
    log, cart = measured(name)
    told = check_sensors(log, guessed(cart, guess * MASS.get(name, cart.inertia.mass)))
    assert {one.kind for one in told} == ({"quantised"} if name in STEPS else set())
    if name in STEPS:
        assert told[0].factor == pytest.approx(STEPS[name], rel=0.03)


@pytest.mark.some(1)
@pytest.mark.long
@pytest.mark.parametrize("name", MASS)
def test_what_is_made_wrong_is_told(name):
    log, cart = measured(name)
    cart = guessed(cart, MASS[name])
    for change, kind in ((-1.0, "sign"), (1e-3, "unit"), (1 / 9.80665, "unit")):
        told = found(check_sensors(with_wrenches(log, lambda w, c=change: c * w), cart))
        assert next(p for (k, where), p in told.items() if k == kind and where in log.arms) > 0.8
    backwards = found(check_sensors(replace(log, pose=log.pose * [-1, 1, 1]), cart))
    assert next(p for (k, where), p in backwards.items() if k == "sign" and where in log.arms) > 0.9
