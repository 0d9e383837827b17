"""A file without constraints of a cart that rolls on fixed wheels; and carts on casters, which may go as they like."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.logs import ArmLog, RunLog
from estimation.sensor_check import check_sensors, look_at

from .logs import CART, two_hands

FREE = replace(CART, constraints=RollingConstraints(axle_x=None))
MASS, INERTIA, STEP = 24.0, 2.4, 0.01


def on_casters(seed, follows_heading, noise=3.0, duration=40.0):
    """A log of a body that goes any way, with drag, pushed by one hand at its CoM: where it heads, as a robot may that
    tracks a path of wheels, or anywhere."""
    random = np.random.default_rng(seed)
    phases, rates = random.uniform(0, 6, 4), random.uniform(0.4, 1.2, 4)
    n = round(duration / STEP)
    pose, twist, rows = np.zeros(3), np.zeros(3), []
    for k in range(n):
        time = k * STEP
        c, s = np.cos(pose[2]), np.sin(pose[2])
        u, w = c * twist[0] + s * twist[1], c * twist[1] - s * twist[0]
        ahead = 0.4 + 0.3 * np.sin(rates[0] * time + phases[0])
        aside = 0.0 if follows_heading else 0.3 * np.sin(rates[1] * time + phases[1])
        turn = 0.5 * np.sin(rates[2] * time + phases[2])
        force = np.array([80.0 * (ahead - u), 200.0 * (aside - w) + MASS * u * twist[2], 10.0 * (turn - twist[2])])
        rows.append([time, *pose, *twist, *force])
        world = np.array([c * force[0] - s * force[1], s * force[0] + c * force[1], force[2]])
        twist = twist + STEP * (world - [3.0, 3.0, 1.0] * twist) / [MASS, MASS, INERTIA]
        pose = pose + STEP * twist
    rows = np.array(rows)
    wrench = np.zeros((n, 6))
    wrench[:, [0, 1, 5]] = rows[:, 7:]
    wrench += np.array([noise] * 3 + [noise / 20] * 3) * random.standard_normal((n, 6))
    sensed = rows[:, 1:7] + np.repeat([5e-4, 5e-3], 3) * random.standard_normal((n, 6))
    return RunLog(rows[:, 0], sensed[:, :3], sensed[:, 3:], {"hand": ArmLog(np.zeros((n, 3)), wrench)})


@pytest.mark.parametrize("seed", range(3))
def test_fixed_wheels_that_a_file_lacks_are_told_with_the_line_to_add(seed):
    (told,) = check_sensors(two_hands(seed), FREE)
    assert (told.kind, told.where, told.is_refused) == ("frame", "pose", True)
    assert "add constraints: [{no_lateral_slip: {x: 0}}]" in told.words
    assert not check_sensors(two_hands(seed), CART)


@pytest.mark.some(4)
@pytest.mark.parametrize("follows_heading", [True, False])
@pytest.mark.parametrize("noise", [0.3, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_casters_alone_may_follow_their_heading(seed, noise, follows_heading):
    assert not check_sensors(on_casters(seed, follows_heading, noise), FREE)


def test_nothing_is_told_where_nothing_turns():
    log = on_casters(0, True)
    still = replace(log, pose=np.zeros_like(log.pose), velocity=np.zeros_like(log.velocity))
    assert not look_at(still, FREE).suspicions


@given(st.floats(0.12, 1.0), st.sampled_from([-1.0, 1.0]), st.integers(0, 3))
@settings(max_examples=8)
def test_an_axle_that_is_elsewhere_is_told_with_where_it_is(distance, sign, seed):
    cart = replace(CART, constraints=RollingConstraints(axle_x=sign * distance))
    (told,) = [one for one in check_sensors(two_hands(seed), cart) if one.kind == "offset"]
    assert told.factor == pytest.approx(-sign * distance, abs=1e-3)
    assert not told.is_refused
    assert "mend no_lateral_slip" in told.words


@pytest.mark.parametrize("distance", [-0.02, 0.0, 0.02])
def test_an_axle_that_is_nearly_there_is_not(distance):
    cart = replace(CART, constraints=RollingConstraints(axle_x=distance))
    assert not check_sensors(two_hands(0), cart)
