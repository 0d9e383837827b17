"""Headings that are not where wheels go, online: the angle against principal axes, and what is told of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import CartFilter, RegressorEstimator
from estimation.online.competing_explanations import BLOCK_FORGETTING_FACTOR
from estimation.online.direction_monitor import DirectionMonitor
from estimation.whole_log.replay import replay
from tests.core.drawn import numbers

from ..runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(3.0, 1.2), RollingResistance(0.02)))


@given(st.lists(st.tuples(numbers(-1.0, 1.0), numbers(-1.0, 1.0)), min_size=2, max_size=8))
def test_the_angle_is_that_of_the_first_principal_axis(ways):
    monitor, products = DirectionMonitor(), np.zeros((2, 2))
    for way in ways:
        monitor, products = monitor.and_then(*way), BLOCK_FORGETTING_FACTOR * products + np.outer(way, way)
    sizes, axes = np.linalg.eigh(products)
    assert monitor.left == pytest.approx(sizes[0], abs=1e-12)
    if sizes[1] - sizes[0] > 1e-6:
        along = np.array([np.cos(monitor.angle), np.sin(monitor.angle)])
        assert abs(along @ axes[:, 1]) == pytest.approx(1.0, abs=1e-6)


def log_with(headings):
    """Of a cart that weaves, with other headings than its own."""
    log = simulate(TRUTH, 4, duration=14.0, noise=(0.0004, 0.005, 0.3))[0]
    return replace(log, pose=np.column_stack([log.pose[:, :2], headings(log.time, log.pose[:, 2])]), velocity=None)


def frames(log, kind=CartFilter, cart=GUESS):
    return [(s.probability, s.words) for s in replay(log, kind(cart, ["hand"])).last.suspicions if s.kind == "frame"]


@pytest.mark.parametrize("kind", [CartFilter, RegressorEstimator])
@pytest.mark.parametrize("angle", [0.4, -0.7])
def test_a_frame_that_is_turned_is_told_with_its_angle(kind, angle):
    (probability, words) = frames(log_with(lambda _, heading: heading + angle), kind)[0]
    assert probability > 0.9
    assert f"goes {np.degrees(-angle):.0f}° beside its heading" in words


def test_a_heading_that_drifts_is_told():
    assert frames(log_with(lambda time, heading: heading + 0.06 * time))


@pytest.mark.parametrize("headings", [lambda _, h: h, lambda _, h: h + 0.1, lambda t, h: h + 0.3 * ((t > 3) & (t < 4))])
def test_what_is_not_far_off_or_not_for_long_is_none(headings):
    assert not frames(log_with(headings))


def test_an_axle_that_is_elsewhere_is_no_turned_frame():
    """It goes sideways in turns, to either side."""
    cart = replace(GUESS, constraints=RollingConstraints(axle_x=0.6))
    assert not frames(log_with(lambda _, heading: heading), cart=cart)
