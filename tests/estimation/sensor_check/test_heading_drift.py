"""Headings that drift, and those whose wheels slip, are turned or drag."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.frames import wrap_angle
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.sensor_check import check_sensors
from estimation.sensor_check.heading import drift_suspicions, heading_drift, without_drift
from estimation.whole_log.identification import identify

from .logs import CART, RAIL, cart_of, found, sealed, two_hands


def drifted(log, rate):
    heading = wrap_angle(log.pose[:, 2] + rate * (log.time - log.time[0]))
    return replace(log, pose=np.column_stack([log.pose[:, :2], heading]))


@settings(max_examples=15)
@given(seed=st.integers(0, 3), rate=st.floats(0.001, 0.02), side=st.sampled_from([-1.0, 1.0]))
def test_a_drift_is_found_and_put_back(seed, rate, side):
    log = two_hands(seed)
    moved = drifted(log, side * rate)
    told = heading_drift(moved, CART)
    assert told.rate == pytest.approx(side * rate, abs=5.0 * told.std + 0.02 * rate)
    assert told.std < 0.1 * rate
    back = without_drift(moved, told)
    assert np.abs(wrap_angle(back.pose[:, 2] - log.pose[:, 2])).max() < 0.04 * rate * log.duration + 2e-3
    (said,) = drift_suspicions(told)
    assert (said.kind, said.where, said.put_right) == ("offset", "heading", True)


@pytest.mark.some(2)
@pytest.mark.parametrize("case", ["nothing", "lateral_slip", "wheel_misalignment", "pose_offset", "external_push"])
def test_what_wheels_do_is_no_drift(case):
    for seed in (9920, 9921):
        log, cart = sealed(case, seed)
        assert heading_drift(log, cart) is None
        assert without_drift(log, None) is log
        assert drift_suspicions(None) == ()


def test_where_nothing_ties_heading_to_travel_there_is_none():
    log = drifted(two_hands(0), 0.01)
    free = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), RollingConstraints(axle_x=None))
    assert heading_drift(log, free) is heading_drift(log, RAIL) is None
    still = replace(log, pose=0.001 * np.random.default_rng(0).standard_normal(log.pose.shape))
    assert heading_drift(still, CART) is None


def test_a_drift_teaches_no_wrong_centre_of_mass():
    """Of 0.005 rad/s. Before, CoM y was told 21 deviations off, and wheels that are turned."""
    log = drifted(replace(two_hands(1), velocity=None), 0.005)
    assert ("offset", "heading") in found(check_sensors(log, CART))
    com_y = identify([log], cart_of(0.8)).parameters["com_y"]
    assert com_y.identifiable
    assert abs(com_y.value - 0.05) < 4.0 * com_y.std < 0.03
