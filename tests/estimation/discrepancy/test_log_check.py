"""What a log can show: how late wrenches are, how it is excited, and what is refused with a reason."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import TimeDelay, ViscousDrag
from cartgrasp.errors import DataError
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation.discrepancy.clock_offset import clock_offsets
from estimation.discrepancy.log_check import check_rows, checked, moving, with_clock_offsets
from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances

from ..runs import STEP, simulate
from .logs import straight

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
LOG, STATES = simulate(TRUTH, 3, 24.0, noise=(0.0004, 0.004, 1.0))
CART = CartModel(Inertia(24.0, (0.2, 0.0), 2.0), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def late(rows, log=LOG):
    """The wrench of each row that is so many rows before; constant where there is none."""
    arm = log.arms["hand"]
    from_row = np.clip(np.arange(len(log)) - rows, 0, len(log) - 1)
    return replace(log, arms={"hand": ArmLog(arm.contact, arm.wrench[from_row])})


def started(log, cart=CART):
    return Model.started([Balances.of(log, cart)], cart)


def check(log, cart=CART):
    check_rows(log)
    return checked(log, cart, Balances.of(log, cart))


def of(log, rows):
    """Some of its rows."""
    arms = {name: ArmLog(arm.contact[rows], arm.wrench[rows]) for name, arm in log.arms.items()}
    velocity = None if log.velocity is None else log.velocity[rows]
    return replace(log, time=log.time[rows], pose=log.pose[rows], velocity=velocity, arms=arms)


@pytest.mark.parametrize("rows", [-2, 0, 1, 3])
def test_wrenches_are_as_late_as_they_were_made(rows):
    """Those of the simulation hold until the next row, so they are half a row early."""
    (found,) = clock_offsets(started(late(rows)))
    assert found.value == pytest.approx((rows - 0.5) * STEP, abs=0.002)
    assert 0.0001 < found.std < 0.002


def test_a_delay_that_the_cart_has_is_part_of_it():
    model = started(late(4))
    named = model.refitted(model.cart.with_effect(TimeDelay(delay=0.03)))
    assert named.wrench_delay == pytest.approx(0.03)
    (found,) = clock_offsets(named)
    assert found.value == pytest.approx(3.5 * STEP, abs=0.002)


def test_of_each_log_its_own():
    model = Model.started([Balances.of(one, CART) for one in (late(2), LOG)], CART)
    found = clock_offsets(model)
    assert [one.value for one in found] == pytest.approx([1.5 * STEP, -0.5 * STEP], abs=0.002)
    told = with_clock_offsets([check(late(2)), check(LOG)], found)
    assert [one.clock_offset for one in told] == list(found)


def test_what_a_steady_push_can_not_tell_is_not_told():
    """A constant force is the same at all times."""
    assert clock_offsets(started(straight(duration=6.0))) == (None,)


def test_a_check_tells_speeds_headings_and_accelerations():
    """Against the truth of the simulation, at its rows."""
    found = check(LOG)
    speed, turning = np.abs(STATES[:, 3]), np.abs(STATES[:, 4])
    moves = (speed > 0.015) | (turning > 0.015)
    assert found.speeds == pytest.approx(np.percentile(speed[moves], [10, 50, 90]), abs=0.02)
    hard = np.abs(np.gradient(STATES[:, 3:], STEP, axis=0))[moves]
    assert found.accelerations == pytest.approx(np.percentile(hard, 95, axis=0), rel=0.2)
    eighths = np.round(STATES[moves, 2] / (np.pi / 4)).astype(int) % 8
    assert found.headings == (np.bincount(eighths, minlength=8) * STEP > 1.0).sum()
    assert found.distance == pytest.approx(speed.sum() * STEP, rel=0.02)
    assert found.turned == pytest.approx(turning.sum() * STEP, rel=0.02)
    assert found.moving == pytest.approx(moves.mean(), abs=0.02)
    assert (found.rows, found.rows_with_wrenches, found.rate) == (2400, 2400, pytest.approx(100.0))
    assert found.noise.position == pytest.approx(0.0004, rel=0.1)
    assert found.noise.force == pytest.approx(1.0, rel=0.1)
    assert found.clock_offset is None


def test_poses_in_steps_have_the_noise_of_rounding():
    """Uniform over a step of 1 cm: its deviation is the step over the root of twelve."""
    pose = LOG.pose.copy()
    pose[:, :2] = np.round(pose[:, :2], 2)
    assert check(replace(LOG, pose=pose)).noise.position >= 0.01 / 12**0.5 * (1 - 1e-6)


def test_a_log_at_one_hertz_is_slow_and_not_full_of_holes():
    """Ten minutes of a motion slow enough to be seen so."""
    time = np.arange(0.0, 600.0, 1.0)
    slow = 2 * np.pi / 60
    pose = np.column_stack([5 * np.sin(slow * time), 0 * time, 0 * time])
    wrench = np.zeros((len(time), 6))
    wrench[:, 0] = -24.0 * 5 * slow**2 * np.sin(slow * time)
    log = RunLog(time, pose, None, {"hand": ArmLog(np.tile([-0.3, 0.0, 1.0], (len(time), 1)), wrench)})
    found = check(log)
    assert found.rate == pytest.approx(1.0)
    assert found.distance == pytest.approx(200.0, rel=0.02)
    assert found.reversals in (19, 20)


class Coasting(RunLog):
    """A log that may have no arms."""

    def __post_init__(self):
        assert not self.arms


def test_a_log_without_arms_needs_no_wrenches():
    log = Coasting(LOG.time, LOG.pose, LOG.velocity, {})
    assert clock_offsets(started(log)) == (None,)
    found = check(log)
    assert found.rows_with_wrenches == 0
    assert found.distance == pytest.approx(check(LOG).distance)
    assert found.noise.force > 0


def test_a_cart_that_stands_has_its_noise_and_is_not_refused():
    log = straight(acceleration=0.0, duration=6.0)
    random = np.random.default_rng(1)
    pose = log.pose + 0.0005 * random.standard_normal(log.pose.shape)
    for still in (log, replace(log, pose=pose, velocity=None)):
        found = check(still)
        assert (found.moving, found.distance, found.reversals) == (0.0, 0.0, 0)
        assert found.speeds == (0.0, 0.0, 0.0)
    assert found.noise.position == pytest.approx(0.0005, rel=0.2)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda log: of(log, slice(0, 30)), "too few"),
        (lambda log: replace(log, pose=np.where(log.time[:, None] > 0.2, np.nan, log.pose)), "whole pose"),
        (lambda log: with_wrench(log, np.nan), "arm arm"),
        (lambda log: with_wrench(log, 0.0), "no wrench ever changes"),
        (lambda log: replace(log, pose=log.pose + np.where(log.time > 3.0, 5.0, 0.0)[:, None] * [1, 0, 0]), "jumps"),
    ],
)
def test_a_log_that_can_not_be_read_is_refused_with_the_reason(spoil, said):
    with pytest.raises(DataError, match=said):
        check(spoil(straight(duration=6.0)))


def with_wrench(log, times):
    arm = log.arms["arm"]
    return replace(log, arms={"arm": ArmLog(arm.contact, arm.wrench * times)})


def test_a_log_full_of_gaps_is_refused():
    """Wrenches and poses that hardly ever come together for as long as a test function."""
    log = straight(duration=20.0)
    arm = log.arms["arm"]
    torn = np.where((log.time % 0.4 < 0.1)[:, None], np.nan, arm.wrench)
    with pytest.raises(DataError, match="come together"):
        check(replace(log, arms={"arm": ArmLog(arm.contact, torn)}))


def test_a_cart_on_casters_moves_sideways_too():
    log, free = straight(duration=6.0), replace(CART, constraints=RollingConstraints(None))
    beside = replace(log, pose=log.pose + np.array([0.0, 0.0, np.pi / 2]))
    ahead, across = (Balances.of(one, free) for one in (log, beside))
    np.testing.assert_allclose(across.motion.speed, ahead.motion.speed, atol=0.01)
    assert moving(across).mean() == pytest.approx(moving(ahead).mean(), abs=0.02)
    assert moving(across).mean() > 0.9
    wrench = log.arms["arm"].wrench * (1 + 0.01 * np.sin(log.time))[:, None]
    told = [
        checked(replace(one, arms={"arm": ArmLog(log.arms["arm"].contact, wrench)}), free, balances).distance
        for one, balances in ((log, ahead), (beside, across))
    ]
    assert told == pytest.approx([9.0, 9.0], rel=0.02)
