"""Recorded wrenches on a grid, against the wave that was sampled."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation.weak_form.balances import Balances

CART = CartModel(Inertia(30.0, (0.0, 0.0), 1.0), RollingConstraints(0.0, no_rotation=True))


def shaken(frequency, rate, jitter):
    """10 N at a frequency (Hz) on 30 kg, seen so often a second (Hz), at times that are a share of a step off."""
    time = np.arange(0.0, 12.0, 1.0 / rate)
    time[1:-1] += jitter / rate * np.sin(7.0 * np.arange(len(time) - 2))
    omega = 2 * np.pi * frequency
    wave = 10.0 * np.sin(omega * time)
    x = 10.0 / 30.0 * (time / omega - np.sin(omega * time) / omega**2)
    place, wrench = np.zeros((len(time), 3)), np.zeros((len(time), 6))
    place[:, 0], wrench[:, 0] = x, wave
    return RunLog(time, place, None, {"arm": ArmLog(np.zeros((len(time), 3)), wrench)})


@pytest.mark.long
@given(st.floats(0.3, 3.0), st.floats(45.0, 400.0), st.floats(0.0, 0.2))
def test_between_samples_a_wrench_goes_as_smoothly_as_the_motion(frequency, rate, jitter):
    """On straight lines 3 Hz at 50 Hz would lose 1.5 %."""
    balances = Balances.of(shaken(frequency, rate, jitter), CART)
    inner = slice(50, -50)
    wave = 10.0 * np.sin(2 * np.pi * frequency * balances.motion.time[inner])
    seen = balances.wrenches.planar(CART)[inner, 0]
    assert wave @ seen / (wave @ wave) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
def test_the_mass_that_balances_is_true(rate):
    balances = Balances.of(shaken(2.0, rate, 0.0), CART)
    left, _ = balances.residual(CART)
    push = balances.integrated(balances.wrenches.planar(CART)[:, :1])[:, 0]
    assert left[:, 0] @ push / (push @ push) == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("apart", [1e-4, 3e-4, 2e-3])
def test_samples_close_together_make_no_noise_louder(apart):
    """Each value is a mean over 10 ms of 2 samples with a noise of 1 N: curves through both had made 10 N of it."""
    pairs = (0.01 * np.arange(1200)[:, None] + [0.0, apart]).ravel()
    place, wrench = np.zeros((len(pairs), 3)), np.zeros((len(pairs), 6))
    place[:, 0] = 0.5 * pairs
    wrench[:, 0] = np.random.default_rng(0).standard_normal(len(pairs))
    log = RunLog(pairs, place, None, {"arm": ArmLog(np.zeros((len(pairs), 3)), wrench)})
    seen = Balances.of(log, CART).wrenches.planar(CART)[50:-50, 0]
    assert 0.3 < seen.std() < 1.2


@pytest.mark.parametrize("sensors", [1, 2, 3])
def test_a_row_for_each_sensor_is_as_good_as_one_for_all(sensors):
    """Poses and wrenches in rows of their own, 0.2 ms apart, and rows in which neither is."""
    log = shaken(2.0, 100.0, 0.0)
    time = (log.time[:, None] + 2e-4 * np.arange(sensors)).ravel()
    pose, wrench = (np.full((len(time), size), np.nan) for size in (3, 6))
    pose[::sensors], wrench[sensors - 1 :: sensors] = log.pose, log.arms["arm"].wrench
    apart = RunLog(time, pose, None, {"arm": ArmLog(np.zeros((len(time), 3)), wrench)})
    one, other = (Balances.of(each, CART) for each in (log, apart))
    assert len(other.used) == pytest.approx(len(one.used), abs=1)
    assert other.sample_step == pytest.approx(0.01)
    assert other.wrench_densities == pytest.approx(one.wrench_densities, rel=1e-3)
    left, _ = other.residual(CART)
    push = other.integrated(other.wrenches.planar(CART)[:, :1])[:, 0]
    assert left[:, 0] @ push / (push @ push) == pytest.approx(0.0, abs=3e-3)
