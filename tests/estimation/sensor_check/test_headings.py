"""Poses whose heading isn't where the wheels go: degrees, signs, axes and frames."""

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
from estimation.sensor_check.heading import heading_suspicions

from .logs import CART, RAIL, found, on_rail, sealed, two_hands

SEEDS = st.integers(0, 3)
FAULTS = {
    "theta in degrees": ("unit", lambda p: np.column_stack([p[:, :2], np.degrees(wrap_angle(p[:, 2]))])),
    "theta turned into radians twice": ("unit", lambda p: p * [1, 1, np.pi / 180]),
    "theta reversed": ("sign", lambda p: p * [1, 1, -1]),
    "y reversed": ("sign", lambda p: p * [1, -1, 1]),
    "x reversed": ("sign", lambda p: p * [-1, 1, 1]),
    "x and y swapped": ("axes", lambda p: p[:, [1, 0, 2]]),
    "theta of the side": ("axes", lambda p: p + np.array([0, 0, np.pi / 2])),
    "another frame": ("frame", lambda p: p + np.array([0, 0, 0.5])),
}


def told(log, change, cart=CART):
    return heading_suspicions(replace(log, pose=change(log.pose)), cart)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_and_no_other(name):
    kind, change = FAULTS[name]
    suspicions = told(two_hands(0), change)
    assert found(suspicions).keys() == {(kind, "pose")}
    assert suspicions[0].is_refused
    assert any(cure in suspicions[0].words for cure in ("multiply", "exchange", "turn", "give"))


@settings(max_examples=10)
@given(SEEDS, st.floats(0.3, 1.2), st.sampled_from([-1, 1]))
def test_any_turn_of_a_frame_is_found(seed, angle, side):
    suspicions = told(two_hands(seed), lambda p: p + np.array([0, 0, side * angle]))
    assert found(suspicions).keys() == {("frame", "pose")}
    assert f"{-side * np.degrees(angle):.0f}°"[:-2] in suspicions[0].words


@settings(max_examples=10)
@given(SEEDS, st.floats(-0.1, 0.1))
def test_wheels_a_little_askew_are_no_fault(seed, angle):
    assert told(two_hands(seed), lambda p: p + np.array([0, 0, angle])) == ()


def test_where_nothing_ties_heading_to_travel_nothing_is_told():
    free = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), RollingConstraints(axle_x=None))
    assert told(two_hands(0), FAULTS["another frame"][1], free) == ()
    assert heading_suspicions(on_rail(), RAIL) == ()
    assert told(two_hands(0), lambda p: 0 * p) == ()


@pytest.mark.parametrize("is_rough", [False, True])
@pytest.mark.parametrize("case", ["nothing", "lateral_slip", "wheel_misalignment"])
def test_logs_with_hidden_effects_raise_no_alarm(case, is_rough):
    assert heading_suspicions(*sealed(case, 1, is_rough)) == ()


@pytest.mark.parametrize("seed", range(6))
def test_a_cart_that_stands_says_nothing(seed):
    """20 s of white noise. Before, two of six were refused, and all told of swapped axes or wrong units."""
    log = two_hands(0)
    noise = np.random.default_rng(seed).standard_normal((2000, 3)) * [0.002, 0.002, 0.002]
    still = replace(log, time=0.01 * np.arange(2000), pose=noise, velocity=None, arms={})
    assert check_sensors(still, CART) == ()
