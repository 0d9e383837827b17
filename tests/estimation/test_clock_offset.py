"""How late wrenches are, and how a log is excited, against logs whose wrenches are moved by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy.clock_offset import clock_offset
from estimation.discrepancy.log_check import checked

from .runs import STEP, simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
LOG, STATES = simulate(TRUTH, 3, 24.0, noise=(0.0004, 0.004, 1.0))


def guess(mass=24.0):
    return CartModel(Inertia(mass, (0.2, 0.0), 2.0))


def late(rows, log=LOG):
    """The wrench of each row that is so many rows before; constant where there is none."""
    arm = log.arms["hand"]
    from_row = np.clip(np.arange(len(log)) - rows, 0, len(log) - 1)
    return replace(log, arms={"hand": ArmLog(arm.contact, arm.wrench[from_row])})


def offset(log, cart=None):
    cart = cart or guess()
    return clock_offset(WrenchRegression(log, cart, None))


@settings(max_examples=8, deadline=None)
@given(st.integers(-18, 18), st.floats(8.0, 80.0))
def test_wrenches_are_as_late_as_they_were_made(rows, mass):
    """Whatever mass is believed; those of the simulation hold until the next row, so they are half a row early."""
    found = offset(late(rows), guess(mass))
    assert found.value == pytest.approx((rows - 0.5) * STEP, abs=0.003)
    assert 0.005 < found.std < 0.008


def test_in_pairs_of_rows_too():
    found = clock_offset(WrenchRegression(late(6), guess(), None, pairs=True))
    assert found.value == pytest.approx(5.5 * STEP, abs=0.003)


def test_what_can_not_be_known_is_not():
    """More than is looked for; noise alone; a log that is too short; wrenches with holes in all that is looked at."""
    assert offset(late(60)) is None
    noise = 5.0 * np.random.default_rng(0).standard_normal((len(LOG), 6))
    alone = offset(replace(LOG, arms={"hand": ArmLog(LOG.arms["hand"].contact, noise)}))
    assert alone is None or alone.std > 0.02
    short = replace(
        LOG,
        time=LOG.time[:150],
        pose=LOG.pose[:150],
        velocity=LOG.velocity[:150],
        arms={"hand": ArmLog(LOG.arms["hand"].contact[:150], LOG.arms["hand"].wrench[:150])},
    )
    assert offset(short) is None
    holes = np.where(np.arange(len(LOG))[:, None] % 40 < 2, np.nan, LOG.arms["hand"].wrench)
    assert offset(replace(LOG, arms={"hand": ArmLog(LOG.arms["hand"].contact, holes)})) is None


def test_a_check_tells_speeds_headings_and_accelerations():
    """Against the truth of the simulation, at its rows."""
    found = checked(LOG, guess(), WrenchRegression(LOG, guess(), None))
    speed, turning = np.abs(STATES[:, 3]), np.abs(STATES[:, 4])
    moves = (speed > 0.015) | (turning > 0.015)
    assert found.speeds == pytest.approx(np.percentile(speed[moves], [10, 50, 90]), abs=0.02)
    hard = np.abs(np.gradient(STATES[:, 3:], STEP, axis=0))[moves]
    assert found.accelerations == pytest.approx(np.percentile(hard, 95, axis=0), rel=0.15)
    eighths = np.round(STATES[moves, 2] / (np.pi / 4)).astype(int) % 8
    assert found.headings == (np.bincount(eighths, minlength=8) * STEP > 1.0).sum()
    assert found.clock_offset.value == pytest.approx(-0.5 * STEP, abs=0.003)
    assert found.as_dict()["clock_offset"]["std"] > 0


def test_a_cart_on_casters_and_one_on_a_rail_have_offsets_too():
    straight, _ = simulate((24.0, 0.0, 0.0, *TRUTH[3:]), 4, 24.0, curved=False, noise=(0.0004, 0.004, 1.0))
    free = replace(guess(), constraints=RollingConstraints(None))
    assert offset(late(5, straight), free).value == pytest.approx(4.5 * STEP, abs=0.01)
    rail = CartModel(Inertia(24.0, (0.0, 0.0), 1.0), RollingConstraints(0.0, no_rotation=True))
    assert offset(late(5, straight), rail).value == pytest.approx(4.5 * STEP, abs=0.01)
