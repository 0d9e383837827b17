"""A file without constraints of a cart that rolls on fixed wheels; and carts on casters, which may go as they like."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.wheel_faults import on_casters
from cartgrasp.constraints import RollingConstraints
from estimation.sensor_check import check_sensors, look_at

from .logs import CART, two_hands

FREE = replace(CART, constraints=RollingConstraints(axle_x=None))


@pytest.mark.some(1)
@pytest.mark.parametrize("seed", range(3))
def test_fixed_wheels_that_a_file_lacks_are_told_with_the_line_to_add(seed):
    (told,) = check_sensors(two_hands(seed), FREE)
    assert (told.kind, told.where, told.is_refused) == ("frame", "pose", True)
    assert "add constraints: [{no_lateral_slip: {x: 0}}]" in told.words
    assert not check_sensors(two_hands(seed), CART)


@pytest.mark.some(2)
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
@settings(max_examples=4)
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
