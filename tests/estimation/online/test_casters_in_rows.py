"""Casters in the regression: what rows say of them, and what they don't."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import CasterRealignment, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.studies import hardware
from cartgrasp.studies.hardware import FILTER_NOISE, HAND, HEAVY_EXPERIMENTS, MIN_LEARNING_SPEED, PRIOR, TURNING
from cartgrasp.wheels import CASTER, FIXED, Wheel
from estimation import CartFilter, FilterNoise, RegressorEstimator
from estimation.gaussian import Gaussian
from estimation.online.kernels.row_algebra import Smoothed, weights
from estimation.online.kernels.row_parts import FILTER_RATE, MEMORY_ERROR_ROWS
from estimation.online.regressor.filtered_row import Block
from estimation.online.regressor.followed_memory import MAX_MEMORY_STD_RATIO, FollowedMemory

from ..runs import wrench_rows
from .declared import filtered_row, unmodelled_noise

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


def along_casters(memory, std):
    """Noise of a row of a cart that rolls straight on, with casters at headings (2,) known to within so much."""
    time, zero, none = 0.01 * np.arange(21), np.zeros((21, 2)), np.zeros((len(CART.parameters), 0))
    exact = np.tile(1e-14 * np.eye(2), (21, 1, 1))
    along = np.tile([0.4, 0.0], (21, 1)), zero, exact, exact[:3], np.tile(memory, (21, 1)), np.tile(std, (21, 1))
    block = Block(
        weights(time, 5),
        Smoothed(time, np.zeros((21, 3)), *along),
        wrench_rows(time[:-1], np.zeros((20, 2)), CART.parameters),
    )
    known = Gaussian(CART.parameters, np.zeros((len(CART.parameters),) * 2))
    return filtered_row(CART, known, none, block, unmodelled_noise(CART, FilterNoise(), np.zeros(0, np.int64))).noise


def test_what_is_not_known_of_a_swing_is_noise():
    """Each caster drags by `(T / b) |sin delta|`, and is as likely off to either side."""
    heading, std = np.array([0.8, 0.8]), np.array([0.3, 0.5])
    noise = along_casters(heading, std) - along_casters(heading, 0.0 * std)
    gain = TORQUE / TRAIL * -np.expm1(-FILTER_RATE * 0.16)
    off = [gain * (np.sin(heading + side * std) - np.sin(heading)) for side in (1.0, -1.0)]
    assert noise[0, 0] == pytest.approx(MEMORY_ERROR_ROWS * 0.5 * np.sum(np.square(off)), rel=5e-3)


def test_a_caster_forgets_where_it_stood_once_it_has_swung_round():
    """Within some trails of travel; and it is not surer of that than casters' own noise lets it be."""
    time = 0.01 * np.arange(301)
    velocity = np.tile([0.4, 0.0], (301, 1))
    exact, none = np.tile(1e-14 * np.eye(2), (301, 1, 1)), np.zeros((301, 0))
    moved = Smoothed(time, np.zeros((301, 3)), velocity, 0.0 * velocity, exact, exact[:3], none, none)
    followed = FollowedMemory(CART, swivel=0.2)
    along = followed.along(moved, CART.parameters)
    spread = MAX_MEMORY_STD_RATIO * CART.memory_spread
    assert along.memory_std[0] == pytest.approx(spread)
    assert (along.memory_std[100] < 1e-3).all()
    after = followed.after(along, 100).along(moved, CART.parameters)
    assert after.memory_std[0] == pytest.approx(0.2, rel=1e-3)
    assert followed.after(along, 100).mean == pytest.approx(along.memory[100])
    assert followed.after(along, 100).lost() == followed


@pytest.mark.long
@pytest.mark.parametrize("least_speed", [0.0, MIN_LEARNING_SPEED])
def test_swivels_that_are_stuck_in_a_turn_are_no_centre_of_mass(least_speed):
    """MuJoCo's casters keep the torque with which they came to rest, 3 N·m on the cart all through a steady turn. Taken
    for noise of a tenth of a second it was a CoM 14 cm off, five standard deviations; an EKF that these forces and
    velocities that jump drive was sure of one 20 cm off."""
    pytest.importorskip("mujoco")
    heavy = replace(HEAVY_EXPERIMENTS[1], path=TURNING[: len(TURNING) // 3])
    log = hardware.record(heavy, hardware.drive(heavy), seed=5)
    estimator = CartFilter(heavy.guess, [HAND], noise=FILTER_NOISE, prior=PRIOR, least_speed=least_speed)
    for row in log.measurements():
        found = estimator.update(row).parameters
    for name, true in (("mass", 80.0), ("com_x", 0.36), ("com_y", 0.05)):
        assert abs(found[name].value - true) < 3 * found[name].std
    assert found["com_x"].std < 0.1
