"""Frames, signs, axes and units of poses and velocities, on carts of the tests' own integrator."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.frames import wrap_angle
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation.sensor_check import check_sensors

from .sensor_logs import CART, RAIL, found, on_rail, sealed, two_hands

SEEDS = st.integers(0, 3)
HARD = {"sign", "unit", "axes", "frame"}


def poses(log, change):
    return replace(log, pose=change(log.pose.copy()))


def velocities(log, change):
    return replace(log, velocity=change(log.velocity.copy()))


def degrees(pose):
    pose[:, 2] = np.degrees(wrap_angle(pose[:, 2]))
    return pose


def turned(pose, angle):
    return pose + np.array([0.0, 0.0, angle])


def of_cart(log):
    theta = two_hands(0).pose[:, 2]
    c, s = np.cos(theta), np.sin(theta)
    vx, vy, omega = log.velocity.T
    return replace(log, velocity=np.column_stack([c * vx + s * vy, c * vy - s * vx, omega]))


FAULTS = {
    "theta in degrees": (("unit", "pose"), lambda log: poses(log, degrees)),
    "theta reversed": (("sign", "pose"), lambda log: poses(log, lambda p: p * [1, 1, -1])),
    "y reversed": (("sign", "pose"), lambda log: poses(log, lambda p: p * [1, -1, 1])),
    "x reversed": (("sign", "pose"), lambda log: poses(log, lambda p: p * [-1, 1, 1])),
    "x and y swapped": (("axes", "pose"), lambda log: poses(log, lambda p: p[:, [1, 0, 2]])),
    "theta of the side": (("axes", "pose"), lambda log: poses(log, lambda p: turned(p, np.pi / 2))),
    "another frame": (("frame", "pose"), lambda log: poses(log, lambda p: turned(p, 0.5))),
    "places in mm": (("unit", "pose"), lambda log: poses(log, lambda p: p * [1000, 1000, 1])),
    "times in ms": (("unit", "time"), lambda log: replace(log, time=1000 * log.time)),
    "velocities in mm/s": (("unit", "velocity"), lambda log: velocities(log, lambda v: v * [1000, 1000, 1])),
    "velocities in km/h": (("unit", "velocity"), lambda log: velocities(log, lambda v: v * [3.6, 3.6, 1])),
    "yaw rates in deg/s": (("unit", "yaw_rate"), lambda log: velocities(log, lambda v: v * [1, 1, 180 / np.pi])),
    "velocities of the cart": (("frame", "velocity"), of_cart),
    "velocities swapped": (("axes", "velocity"), lambda log: velocities(log, lambda v: v[:, [1, 0, 2]])),
    "velocities reversed": (("sign", "velocity"), lambda log: velocities(log, lambda v: v * [-1, -1, 1])),
    "vy reversed": (("sign", "velocity"), lambda log: velocities(log, lambda v: v * [1, -1, 1])),
    "yaw rates reversed": (("sign", "yaw_rate"), lambda log: velocities(log, lambda v: v * [1, 1, -1])),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told_and_no_other(name):
    wanted, change = FAULTS[name]
    told = {key: p for key, p in found(check_sensors(change(two_hands(0)), CART)).items() if key[0] != "holes"}
    assert set(told) == {wanted}
    assert told[wanted] > 0.9


@pytest.mark.parametrize("name", FAULTS)
def test_refused_ones_come_first_and_say_the_cure(name):
    first, *_ = check_sensors(FAULTS[name][1](two_hands(0)), CART)
    assert first.is_refused
    cures = ("multiply", "exchange", "turn", "give")
    assert any(cure in first.words for cure in cures)


@settings(max_examples=8)
@given(SEEDS, st.floats(0.3, 1.2), st.booleans())
def test_any_turn_of_a_frame_is_found(seed, angle, back):
    """Quarter turns are told as such from 80° on; less than a fifth of a radian may be a cart with wheels askew."""
    angle = -angle if back else angle
    told = found(check_sensors(poses(two_hands(seed), lambda p: turned(p, angle)), CART))
    assert told.keys() == {("frame", "pose")}


@settings(max_examples=8)
@given(SEEDS, st.floats(-0.1, 0.1))
def test_wheels_a_little_askew_are_no_fault(seed, angle):
    assert found(check_sensors(poses(two_hands(seed), lambda p: turned(p, angle)), CART)) == {}


@settings(max_examples=8)
@given(SEEDS, st.floats(0.7, 1.4))
def test_scales_are_no_units(seed, gain):
    told = found(check_sensors(velocities(two_hands(seed), lambda v: gain * v), CART))
    assert not {kind for kind, _ in told} & HARD


def test_a_cart_on_casters_may_go_any_way():
    """Without fixed wheels nothing ties heading to travel; velocities and yaw rates still tie theirs."""
    free = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), RollingConstraints(axle_x=None))
    sideways = poses(two_hands(0), lambda p: turned(p, 0.7))
    assert found(check_sensors(sideways, free)).keys() <= {("frame", "left"), ("frame", "right")}
    slow = velocities(two_hands(0), lambda v: v * [1, 1, 180 / np.pi])
    assert ("unit", "yaw_rate") in found(check_sensors(slow, free))


def test_a_rail_is_sound_and_across_it_nothing_goes():
    assert found(check_sensors(on_rail(), RAIL)) == {}
    across = replace(on_rail(), pose=on_rail().pose[:, [1, 0, 2]], velocity=on_rail().velocity[:, [1, 0, 2]])
    told = found(check_sensors(across, RAIL))
    assert told[("axes", "pose")] > 0.8


@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_slow_logs_are_not_in_milliseconds(rate):
    """Every so many rows of a cart that creeps."""
    every = round(100 / rate)
    log = two_hands(0, duration=60.0)
    slow = RunLog(log.time[::every], log.pose[::every], None, thinned(log, every))
    assert not {key for key in found(check_sensors(slow, CART)) if key[0] in HARD}


def thinned(log, every):
    return {name: ArmLog(arm.contact[::every], arm.wrench[::every]) for name, arm in log.arms.items()}


@pytest.mark.parametrize("is_rough", [False, True])
@pytest.mark.parametrize(
    ("case", "seed"), [("nothing", 0), ("lateral_slip", 1), ("wheel_misalignment", 1), ("time_delay", 2)]
)
def test_logs_with_hidden_effects_raise_no_alarm(case, seed, is_rough):
    log, cart = sealed(case, seed, is_rough)
    assert not {key for key in found(check_sensors(log, cart)) if key[0] in HARD | {"lag", "scale"}}
