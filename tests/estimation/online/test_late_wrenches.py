"""Wrenches that come late, or early, by a time that nobody told: it is learned from them, and moves no parameter."""

import numpy as np
import pytest

from benchmarks import broken_sensors
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, FilterNoise, Prior, RegressorEstimator
from estimation.gaussian import Gaussian
from estimation.log_noise.log_noise import noise_of_log
from estimation.online.kernels.row_algebra import Smoothed, weights
from estimation.online.kernels.row_parts import NOMINAL_DELAY_PERIODS
from estimation.online.regressor.filtered_row import Block
from estimation.online.regressor.motion_tracker import MotionTracker
from estimation.whole_log.replay import replay

from ..runs import simulate, wrench_rows
from .declared import filtered_row, unmodelled_noise

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0), RollingResistance(0.015)))
PLAIN = CartModel(Inertia(24.0, (0.28, 0.06), 2.2))
TIME = 0.01 * np.arange(26)


def row(wrenches, late=0.0, ahead=0.0):
    """Of a cart at rest, whose wrenches (n, 2) were so late (s), with sensor noise of 1 N and 1 N·m."""
    zero, exact = np.zeros((26, 3)), np.tile(1e-14 * np.eye(2), (26, 1, 1))
    moved = Smoothed(TIME, zero, zero[:, :2], zero[:, :2], exact, exact[:3], zero[:, :0], zero[:, :0])
    rows = wrench_rows(TIME[:-1], wrenches(TIME[:-1] - late), PLAIN.parameters)
    known, block = Gaussian(PLAIN.parameters, np.zeros((4, 4))), Block(weights(TIME, 8), moved, rows, ahead)
    return filtered_row(
        PLAIN, known, np.zeros((4, 0)), block, unmodelled_noise(PLAIN, FilterNoise(), np.zeros(0, np.int64))
    )


def swinging(time):
    return np.column_stack([20.0 * np.sin(2.0 * time + 0.3), 3.0 * np.cos(1.5 * time)])


def test_the_slope_by_the_lateness_is_what_a_lateness_does():
    late, early = row(swinging, 0.01), row(swinging, -0.01)
    slope = (late.residual - early.residual) / 0.02
    assert row(swinging).slopes[:, -1] == pytest.approx(slope, rel=0.01)


def test_near_a_step_the_slope_changes_with_the_lateness():
    """By the second difference of what a lateness does; in smooth wrenches noise hides it, and it is none."""

    def step(time):
        size = np.tanh((time - 0.05) / 0.012)
        return np.column_stack([400.0 * size, -60.0 * size])

    bend = (row(step, 0.01).residual - 2.0 * row(step).residual + row(step, -0.01).residual) / 0.01**2
    found = row(step).bent_by_delay
    assert np.abs(found) == pytest.approx(np.abs(bend), rel=0.15)
    assert np.sign(found[0] * found[1]) == np.sign(bend[0] * bend[1])
    assert not row(swinging).bent_by_delay.any()


def test_a_row_knows_which_samples_it_was_given():
    """Of wrenches that are not late, samples that were recorded later tell as much, but for what bends in between."""
    later = row(swinging, -0.03, ahead=0.03)
    assert later.residual == pytest.approx(row(swinging).residual, rel=5e-3)


def test_noise_of_wrenches_is_in_the_slope_and_in_the_residual():
    random = np.random.default_rng(0)
    drawn = [row(lambda time: random.standard_normal((len(time), 2))) for _ in range(4000)]
    slopes, residuals = np.array([(one.slopes[:, -1], one.residual) for one in drawn]).transpose(1, 0, 2)
    own, with_residual = drawn[0].of_delay
    assert np.diagonal(own) == pytest.approx(np.var(slopes, axis=0), rel=0.1)
    size = np.sqrt(own[0, 0] * np.var(residuals))
    assert np.diagonal(with_residual) == pytest.approx(np.mean(slopes * residuals, axis=0), abs=0.05 * size)


@pytest.mark.parametrize("late", [0.03, -0.03])
def test_samples_that_stand_for_several_moments_are_moved_by_their_times(late):
    """A wrench that says the time, recorded with every third moment, of moments that are 1, 2 and 7 ms apart."""
    tracker, grip = MotionTracker(PLAIN, FilterNoise()), np.hstack([np.eye(2), np.eye(2)])
    believed = np.concatenate([np.zeros(8), PLAIN.parameters, np.eye(2).ravel()])
    tracker.start(0.0, np.zeros(3))
    times = np.cumsum(np.tile([0.001, 0.002, 0.007], 60))
    for i, time in enumerate(times.tolist()):
        said = np.array([100.0 * time, 0.0]) if i % 3 == 0 else np.zeros(0)
        tracker.record(time, np.zeros(6), said, grip, believed)
    tracker.drop(45)
    step = np.diff(tracker.time[:91])
    usual, nothing = tracker.wrenches(90, 0.0)
    found, ahead = tracker.wrenches(90, late)
    assert nothing == 0.0
    assert ahead == pytest.approx(late, abs=0.005)
    assert np.average(found[:, 1] - usual[:, 1], weights=step) == pytest.approx(100.0 * ahead)


@pytest.mark.long
@pytest.mark.parametrize("slope", [0.0, 0.007])
def test_steps_of_the_push_teach_no_more_than_they_do(slope):
    """While it is not known how late wrenches are, a step of 24 N and 14 N·m tells more of that than of the cart. Rows
    that are linear in it told inertias 3.6 deviations off, and 7 where motion is known ten times better."""
    truth, guess = (26.0, 0.27, 0.02, 2.2, 3.0, 1.2, 0.0), PLAIN.with_effect(ViscousDrag(3.0, 1.2))
    prior = Prior(mass=0.15, com=0.04, inertia=0.3, slope=slope, known={"viscous_drag"})
    noise, errors = FilterNoise(1e-4, 1e-4, 1e-3, 1e-3, force=1.0, moment=0.05), []
    for seed in range(8):
        cart = CartModel(Inertia(*truth[:1], truth[1:3], truth[3]), effects=guess.effects)
        plant, sensors = ModelPlant(cart), Sensors(cart, SensorNoise(1e-4, 1e-4, 1e-3, 1e-3, 1.0, 0.05), seed)
        learner = CartFilter(guess, ["hand"], noise=noise, prior=prior)
        for tick in range(250):
            force, moment = (28.0, 0.0) if tick < 70 else (4.0, 14.0 * np.cos(0.06 * (tick - 70)))
            given = ContactWrenches({"hand": [force, 0.0, 0.0, 0.0, 0.0, moment]}, {"hand": np.zeros(3)})
            learner.update(sensors.motion(plant.time, plant.motion))
            told = learner.update(sensors.wrenches(plant.time, given)).parameters
            plant.step(given, 0.01)
        true = zip(("mass", "com_x", "com_y", "inertia"), truth[:4], strict=True)
        errors.append([(told[name].value - value) / told[name].std for name, value in true])
    assert np.sqrt(np.mean(np.square(errors), axis=0)).max() < 1.5
    assert np.abs(errors).max() < 3.5


@pytest.mark.some(2)
@pytest.mark.parametrize("late", [0.05, 0.025, -0.03])
@pytest.mark.parametrize("force", [0.3, 2.0])
def test_lateness_is_learned_and_moves_nothing(late, force):
    log = simulate(TRUTH, 6, 20.0, noise=(0.0003, 0.003, force))[0]
    moved = broken_sensors.late(late)(log)
    estimator = RegressorEstimator(GUESS, ["hand"], noise=noise_of_log(moved, GUESS))
    last = replay(moved, estimator).last
    assert estimator.lateness == pytest.approx(late - NOMINAL_DELAY_PERIODS * 0.01, abs=0.004 if force < 1 else 0.015)
    assert last.health == "ok"
    for name, true in zip(("mass", "com_x", "com_y", "viscous_drag.linear"), (24.0, 0.28, 0.06, 3.0), strict=True):
        told = last.parameters[name]
        assert abs(told.value - true) < 3.0 * told.std
    assert last.parameters["mass"].std < (0.2 if force < 1 else 0.6)
