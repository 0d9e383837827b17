"""What a model leaves, as means over stretches: forces and angles that were put in; noise against its deviations."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import grasp_map_planar
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.discrepancy.search.covariates import Covariates, since_reversal
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.where.circumstances import Circumstances, arm_wrenches
from estimation.discrepancy.where.residual import LATERAL_VELOCITY, residuals
from estimation.discrepancy.where.residual_map import residual_maps
from estimation.discrepancy.where.where import where
from estimation.weak_form.balances import Balances

from ...runs import simulate
from ..logs import circles

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def started(log, cart=CART):
    return Model.started([Balances.of(log, cart)], cart)


@pytest.fixture(scope="module")
def log():
    return simulate(TRUTH, 7, 20.0, noise=(0.0005, 0.005, 1.0))[0]


@pytest.fixture(scope="module")
def quiet(log):
    return started(log)


def with_force(log, force):
    """Of a hand that feels so much more (n,) forward."""
    arm = log.arms["hand"]
    more = np.zeros_like(arm.wrench)
    more[:, 0] = force
    return replace(log, arms={"hand": ArmLog(arm.contact, arm.wrench + more)})


@pytest.mark.long
def test_a_force_that_nobody_knows_of_is_in_the_forward_residual(log, quiet):
    """5 N backward for 3 s; means and times in the words of the log."""
    model = started(with_force(log, 5.0 * ((log.time >= 9.0) & (log.time < 12.0))))
    forward, yaw, aside = residuals(model, quiet)
    inside = (forward.start >= 9.0) & (forward.start < 11.6)
    assert forward.value[inside].mean() - forward.value[~inside].mean() == pytest.approx(5.0, rel=0.2)
    assert (forward.coordinate, yaw.coordinate, aside.coordinate) == ("forward_force", "yaw_moment", LATERAL_VELOCITY)
    assert (yaw.unit, aside.unit) == ("N·m", "m/s")
    first = where([forward])[0]
    assert (first.start, first.stop) == pytest.approx((9.0, 12.0), abs=0.6)


@pytest.mark.long
def test_means_of_noise_are_as_large_as_their_deviations():
    """Over eight logs. What rows are unsure of beside the sensors' noise (forms of friction near rest) is not in them,
    so they may be smaller."""
    told = [
        residuals(model, model)[:2]
        for model in (started(simulate(TRUTH, seed, 12.0, noise=(0.0005, 0.005, 2.0))[0]) for seed in range(8))
    ]
    for k in range(2):
        standard = np.array([one[k].standard for one in told])
        assert 0.25 < (standard**2).mean() < 1.3
        assert not sum(one[k].disagrees for one in told)


def test_what_overlaps_is_not_known_twice(quiet):
    """By the whole covariance of the rows, solved for densely."""
    forward = residuals(quiet, quiet)[0]
    (balances,), (whiten,) = quiet.logs, quiet.whitenings
    k = len(balances.used)
    unit = np.tile(np.eye(k)[:, None, :], (1, whiten.counts.shape[1], 1))
    factor = np.linalg.inv(replace(whiten, counts=np.ones_like(whiten.counts))(unit)[:, 0])
    covariance = factor @ factor.T
    own = (balances.time >= forward.start[3]) & (balances.time < forward.start[3] + forward.duration)
    mean = own / own.sum() / balances.row_step
    assert forward.std[3] == pytest.approx(np.sqrt(mean @ covariance @ mean))
    assert forward.value[3] == pytest.approx(mean @ quiet.residual[:, 0])


def test_gaps_have_no_means(log):
    """Where no wrench was recorded for 4 s."""
    arm = log.arms["hand"]
    missing = (log.time > 8.0) & (log.time < 12.0)
    torn = replace(log, arms={"hand": ArmLog(arm.contact, np.where(missing[:, None], np.nan, arm.wrench))})
    model = started(torn)
    for one in residuals(model, model):
        assert not ((one.start > 8.1) & (one.start < 11.4)).any()
        assert len(one.start) == pytest.approx(32, abs=1)


def test_wheels_at_an_angle_go_sideways_in_proportion_to_the_speed():
    """What a model with square wheels leaves; without an angle it is noise."""
    bare = CartModel(Inertia(24.0, (0.28, 0.06), 2.2))
    straight = started(circles(), bare)
    found = residuals(started(circles(angle=0.03), bare), straight)[-1]
    assert found.coordinate == LATERAL_VELOCITY
    assert np.polyfit(found.circumstances.covariates.speed, found.value, 1)[0] == pytest.approx(np.tan(0.03), rel=0.1)
    assert found.disagrees
    assert not residuals(straight, straight)[-1].disagrees


def test_a_rail_has_neither_headings_nor_a_lateral_velocity():
    log, _ = simulate(TRUTH, 7, 12.0, curved=False)
    rail = CartModel(Inertia(24.0, (0.0, 0.0), 1.0), RollingConstraints(0.0, no_rotation=True))
    model = started(log, rail)
    (forward,) = residuals(model, model)
    names = [one.variable for one in residual_maps([forward], [forward])]
    assert "speed" in names
    assert "heading" not in names


def test_logs_follow_one_another(log):
    """Times are each log's own, and so are ways."""
    later = replace(log, time=log.time + 1000.0, name="later")
    model = Model.started([Balances.of(one, CART) for one in (log, later)], CART)
    forward = residuals(model, model)[0]
    found = forward.circumstances
    one, other = (found.log == k for k in range(2))
    assert one.sum() == other.sum()
    np.testing.assert_allclose(forward.start[other], forward.start[one] + 1000.0)
    np.testing.assert_allclose(
        found.covariates.travelled[other], found.covariates.travelled[one], atol=1e-6
    )  # of rounding
    np.testing.assert_allclose(found.covariates.time[other], found.covariates.time[one])


def test_arms_give_what_their_wrenches_are_in_b(log):
    one = log.arms["hand"]
    arms = {"left": one, "right": ArmLog(one.contact + np.array([0.1, -0.3, 0.4]), 2 * one.wrench)}
    balances = Balances.of(replace(log, arms=arms), CART)
    for name, wrench in arm_wrenches(balances, CART, 0.05).items():
        planar = np.einsum("nij,nj->ni", grasp_map_planar(arms[name].contact), arms[name].wrench)
        smooth = np.array([planar[max(i - 5, 0) : i + 6].mean(axis=0) for i in range(len(planar))])
        inside = slice(10, len(wrench) - 10)
        difference = wrench[inside] - smooth[: len(wrench)][inside]
        assert np.sqrt((difference**2).mean()) < 0.02 * np.sqrt((smooth**2).mean())


def test_a_contact_is_where_it_was_last_seen(log):
    contact = np.tile([-0.3, 0.1, 1.0], (len(log), 1))
    contact[log.time >= 10.0] = [-0.3, -0.2, 1.0]
    contact[::3] = np.nan
    moved = replace(log, arms={"hand": ArmLog(contact, log.arms["hand"].wrench)})
    balances = Balances.of(moved, CART)
    time = np.array([5.0, 9.95, 10.05, 15.0])
    found = Circumstances.of(time, np.zeros(4, dtype=int), [balances], CART)
    np.testing.assert_allclose(found.contacts["hand"][:, 1], [0.1, 0.1, -0.2, -0.2])
    np.testing.assert_allclose(found.total, found.wrenches["hand"])


def test_a_course_is_that_of_the_motion():
    """Against the truth of the simulation, at its rows."""
    log, states = simulate(TRUTH, 3, 12.0, noise=(0.0004, 0.004, 1.0))
    late = replace(log, time=log.time + 50.0)
    time = np.array([3.0, 7.0, 11.0])
    course = Covariates.of(time + 50.0, np.zeros(3, dtype=int), [Balances.of(late, CART).motion])
    rows = np.searchsorted(log.time, time - 1e-9)
    np.testing.assert_allclose(course.time, time, atol=1e-6)
    np.testing.assert_allclose(course.place, states[rows, :2], atol=0.002)
    np.testing.assert_allclose(course.heading, states[rows, 2], atol=0.005)
    np.testing.assert_allclose(course.speed, states[rows, 3], atol=0.02)
    np.testing.assert_allclose(course.yaw_rate, states[rows, 4], atol=0.03)
    steps = np.append(0.0, np.cumsum(states[:-1, 3] * 0.01))
    np.testing.assert_allclose(course.way, steps[rows], atol=0.02)
    steps = np.append(0.0, np.cumsum(np.abs(states[:-1, 3]) * 0.01))
    np.testing.assert_allclose(course.travelled, steps[rows], atol=0.02)


def test_a_reversal_is_a_change_of_direction_and_no_stop():
    speed = np.repeat([0.5, 0.0, 0.4, 0.01, -0.3, 0.0, -0.3, 0.5], 10)
    travelled = np.cumsum(np.abs(speed))
    found = since_reversal(speed, travelled)
    assert np.isinf(found[:40]).all()
    np.testing.assert_allclose(found[40:70], travelled[40:70] - travelled[40])
    np.testing.assert_allclose(found[70:], travelled[70:] - travelled[70])
    assert np.isinf(since_reversal(speed[:40], travelled[:40])).all()


def test_parts_of_a_log_are_one(log):
    """As between impacts: the same name, and times that go on."""
    parts = [replace(log, **cut_at(log, rows)) for rows in (slice(0, 900), slice(950, None))]
    model = Model.started([Balances.of(part, CART) for part in parts], CART)
    found = residuals(model, model)[0].circumstances
    assert found.names == (log.name,)
    assert set(found.log) == {0}


def cut_at(log, rows):
    arms = {name: ArmLog(arm.contact[rows], arm.wrench[rows]) for name, arm in log.arms.items()}
    return {"time": log.time[rows], "pose": log.pose[rows], "velocity": log.velocity[rows], "arms": arms}
