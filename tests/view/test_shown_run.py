"""What is shown of a log, and of an estimate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.inertia import physical_from_phi
from cartgrasp.logs.run_log import RunLog
from cartgrasp.motion import Estimate, Motion, ParameterEstimate
from cartgrasp.simulation.record import RunRecord
from cartgrasp.view.shown_run import ShownRun

from .conftest import shopping_cart

SPREAD = np.array([[0.3, 0.02, -0.01, 0.05], [0, 0.1, 0.03, 0.02], [0, 0, 0.08, 0.01], [0, 0, 0, 0.2]])


def estimate(covariance: np.ndarray | None = None) -> Estimate:
    cart = shopping_cart()
    p = len(cart.parameters)
    whole = np.zeros((p, p))
    whole[:4, :4] = SPREAD.T @ SPREAD if covariance is None else covariance
    mass = ParameterEstimate(24.0, 0.3, "kg", True)
    return Estimate(0.0, Motion(np.zeros(3), np.zeros(2)), {"mass": mass}, "ok", cart, cart.parameters, whole)


def test_the_spread_of_the_centre_of_mass_is_that_of_draws():
    """Drawn parameters, each made physical by itself, against the covariance by partials."""
    small = 1e-4 * SPREAD.T @ SPREAD
    found = estimate(small).com_covariance
    draws = np.random.default_rng(0).multivariate_normal(shopping_cart().inertia.phi, small, size=200_000)
    np.testing.assert_allclose(found, np.cov(physical_from_phi(draws)[:, 1:3].T), rtol=0.03, atol=1e-10)
    assert estimate()._replace(covariance=None).com_covariance is None


def test_what_stands_as_the_file_has_it_is_no_estimate(record: RunRecord):
    told = estimate()
    trail = ParameterEstimate(0.05, 0.0, "m", False)
    both = told._replace(parameters={**told.parameters, "caster_realignment.trail": trail})
    assert set(ShownRun.of_log(record.log, record.cart, [both] * len(record.time)).parameters) == {"mass"}
    held = replace(record.parameters["mass"], std=0 * record.parameters["mass"].std)
    shown = ShownRun.of_record(replace(record, parameters={**record.parameters, "held": held}))
    assert set(shown.parameters) == set(record.parameters)


def test_a_log_shows_what_the_record_of_its_run_does(record: RunRecord, shown: ShownRun):
    told = ShownRun.of_log(record.log, record.cart, [estimate()] * len(record.time))
    np.testing.assert_allclose(told.velocity_b[200:], shown.velocity_b[200:], atol=0.02)
    # The record's casters began askew, which poses can't tell; once they have rolled, both agree.
    assert told.caster_headings is not None
    assert shown.caster_headings is not None
    rolling = slice(1000, 5500)
    np.testing.assert_allclose(told.caster_headings[rolling], shown.caster_headings[rolling], atol=0.05)
    assert told.com_covariance is not None
    assert told.com_covariance.shape == (len(record.time), 2, 2)
    assert set(told.healths) == {"ok"}
    assert told.statuses == ()
    assert told.tracking_error is None


def test_casters_that_a_plant_does_not_have_trail_as_poses_tell(record: RunRecord, shown: ShownRun):
    found = ShownRun.of_record(replace(record, caster_headings=None)).caster_headings
    assert found is not None
    assert shown.caster_headings is not None
    np.testing.assert_allclose(found[1000:5500], shown.caster_headings[1000:5500], atol=0.05)


def test_clocks_of_an_epoch_are_shown_from_the_start(record: RunRecord):
    log = record.log
    late = RunLog(log.time + 1.7e9, log.pose, None, log.arms)
    np.testing.assert_allclose(ShownRun.of_log(late).time, log.time, atol=1e-6)
    np.testing.assert_array_equal(ShownRun.of_log(log).time, log.time)


def test_averaged_for_print(shown: ShownRun):
    few = shown.averaged()
    assert len(few.time) == 1200
    wrench = shown.wrenches["left"]
    np.testing.assert_allclose(few.wrenches["left"].mean(axis=0), wrench.mean(axis=0))
    np.testing.assert_allclose(few.wrenches["left"][10], wrench[50:55].mean(axis=0))
    for values in (
        few.pose,
        few.reference_pose,
        few.caster_headings,
        few.parameters["mass"].value,
        few.contacts["left"],
    ):
        assert values is not None
        assert len(values) == len(few.time)
    np.testing.assert_array_equal(few.pose[10], shown.pose[52])
    assert few.time[10] == shown.time[52]
    assert few.averaged() is few
    assert few.tracking_error is not None
    assert few.tracking_error.mean() == pytest.approx(shown.tracking_error.mean(), rel=0.01)


def test_a_cart_that_is_not_known_is_drawn_round_where_it_is_usually_held(shown: ShownRun):
    contact = shown.contacts["left"].copy()
    contact[:5], contact[5:9] = 1e300, np.nan
    x0, x1, y0, y1 = replace(shown, cart=None, contacts={"left": contact}).outline
    assert x0 < -0.25 < 0 < x1 < 1
    assert y0 < 0 < 0.10 < y1 < 1


def test_what_can_not_be_in_si_units_counts_as_missing(record: RunRecord):
    log, pose = record.log, record.log.pose.copy()
    pose[100] = 1e300
    arms = {"left": replace(log.arms["left"], wrench=np.where(np.arange(6) == 2, -2e5, log.arms["left"].wrench))}
    told = ShownRun.of_log(replace(log, pose=pose, arms=arms), record.cart)
    assert np.isnan(told.pose[100]).all()
    assert np.isfinite(np.delete(told.pose, 100, axis=0)).all()
    np.testing.assert_array_equal(np.isnan(told.wrenches["left"]).all(axis=0), np.arange(6) == 2)
