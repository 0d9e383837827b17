"""Casters in the regression: what rows say of them, and what they don't."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import CasterRealignment, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.studies import hardware
from cartgrasp.studies.hardware import HAND, HEAVY, LEAST_SPEED, NOISE, PRIOR, TURNING
from cartgrasp.wheels import CASTER, FIXED, Wheel
from estimation import CartFilter, FilterNoise, RegressorEstimator
from estimation.gaussian import Gaussian
from estimation.online.kernels.filtered_row import RATE, Smoothed, weights
from estimation.online.regressor import filtered_row as rows
from estimation.online.regressor.filtered_row import Block, filtered_row

from ..runs import wrench_rows

TRAIL, TORQUE = 0.045, 0.12
WHEELS = (
    *(Wheel(FIXED, 0.0, y) for y in (0.27, -0.27)),
    *(Wheel(CASTER, 0.72, y, trail=TRAIL) for y in (0.2, -0.2)),
)
CART = CartModel(
    Inertia(30.0, (0.36, 0.0), 2.7),
    effects=(ViscousDrag(3.0, 1.0), CasterRealignment(swivel_torque=TORQUE)),
    wheels=WHEELS,
)


def test_casters_that_trail_tell_nothing_of_their_torque():
    """Straight on, the noise of a yaw rate looks as if they swivelled, and no moment answers: for a torque of 0 that
    would be ever more evidence."""
    random, estimator = np.random.default_rng(0), RegressorEstimator(CART, ["hand"], noise=FilterNoise(force=3.0))
    first = np.sqrt(estimator.prior.covariance(CART)[-2, -2])
    for k in range(500):
        pose = np.array([0.004 * k, 0.0, 0.0]) + 0.0005 * random.standard_normal(3)
        velocity = np.array([0.4, 0.0, 0.0]) + 0.005 * random.standard_normal(3)
        wrench = np.array([1.2, 0.0, 0.0, 0.0, 0.0, 0.0]) + random.standard_normal(6) * np.repeat([3.0, 0.1], 3)
        estimator.update(Measurement(0.01 * k, pose, velocity, {"hand": wrench}, {"hand": np.zeros(3)}))
    found = estimator.estimate.parameters["caster_realignment.swivel_torque"]
    assert found.std > 0.5 * first
    assert abs(found.value - TORQUE) < found.std


def test_a_swing_is_noise_of_its_own_size(monkeypatch):
    """Casters held across: the drag (T / b) of each, known to within itself."""
    time, zero = 0.01 * np.arange(21), np.zeros((21, 2))
    exact = np.tile(1e-14 * np.eye(2), (21, 1, 1))
    velocity, memory = np.tile([0.4, 0.0], (21, 1)), np.full((21, 2), np.pi / 2)
    moved = Smoothed(time, np.zeros((21, 3)), velocity, zero, exact, exact[:3], memory)
    block = Block(weights(time, 5), moved, wrench_rows(time[:-1], np.zeros((20, 2)), CART.parameters))
    known = Gaussian(CART.parameters, np.zeros((len(CART.parameters),) * 2))
    spread = np.zeros((len(CART.parameters), 0))
    noise = filtered_row(CART, known, spread, block, rows.left_out(CART, FilterNoise(), np.zeros(0, np.int64))).noise
    monkeypatch.setattr(rows, "REMEMBERED_SHARE", 0.0)
    without = filtered_row(CART, known, spread, block, rows.left_out(CART, FilterNoise(), np.zeros(0, np.int64))).noise
    drag = 2 * TORQUE / TRAIL * -np.expm1(-RATE * 0.16)
    assert (noise - without)[0, 0] == pytest.approx(drag**2, rel=1e-3)


@pytest.mark.parametrize("least_speed", [0.0, LEAST_SPEED])
def test_swivels_that_are_stuck_in_a_turn_are_no_centre_of_mass(least_speed):
    """MuJoCo's casters keep the torque with which they came to rest, 3 N·m on the cart all through a steady turn. Taken
    for noise of a tenth of a second it was a CoM 14 cm off, five standard deviations; an EKF that these forces and
    velocities that jump drive was sure of one 20 cm off."""
    pytest.importorskip("mujoco")
    heavy = replace(HEAVY[1], path=TURNING[: len(TURNING) // 3])
    log = hardware.record(heavy, hardware.drive(heavy), seed=5)
    estimator = CartFilter(heavy.guess, [HAND], noise=NOISE, prior=PRIOR, least_speed=least_speed)
    for row in log.measurements():
        found = estimator.update(row).parameters
    for name, true in (("mass", 80.0), ("com_x", 0.36), ("com_y", 0.05)):
        assert abs(found[name].value - true) < 3 * found[name].std
    assert found["com_x"].std < 0.1
