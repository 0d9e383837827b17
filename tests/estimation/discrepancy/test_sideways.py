"""Wheels that roll at an angle, or creep: what is told of a cart that goes round in circles of the tests' own."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose

from .logs import circles

CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2))


def told(log, cart=CART):
    """Values of the effects that are named, by name."""
    found = diagnose(log, cart)
    return {effect.name: {k: value for k, (value, _, _) in effect.parameters.items()} for effect in found.effects}


@pytest.mark.prove
@pytest.mark.parametrize("angle", [0.03, -0.01])
def test_wheels_at_an_angle_show_sideways(angle):
    found = told(circles(angle))
    assert list(found) == ["wheel_misalignment"]
    assert found["wheel_misalignment"]["angle"] == pytest.approx(angle, abs=3e-4)


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("spoiled", [False, True])
def test_headings_are_taken_as_they_were_recorded(spoiled):
    """Smoothed as if wheels were square, they lean towards where the cart went; but for what is missing, or a slip of
    the tracker."""
    log, random = circles(0.07), np.random.default_rng(1)
    pose = log.pose + [0.0013, 0.0013, 0.0034] * random.standard_normal(log.pose.shape)
    if spoiled:
        pose[400, 2] += 0.5
        pose[900:903, 2] = np.nan
    found = told(replace(log, pose=pose, velocity=None))
    assert list(found) == ["wheel_misalignment"]
    assert found["wheel_misalignment"]["angle"] == pytest.approx(0.07, abs=8e-4)


@pytest.mark.long
def test_creeping_wheels_show_sideways():
    found = told(circles(compliance=1 / 600.0), replace(CART, inertia=Inertia(24.0, (0.28, 0.0), 2.2)))
    assert list(found) == ["lateral_slip"]
    assert found["lateral_slip"]["cornering_stiffness"] == pytest.approx(600.0, rel=0.1)


@pytest.mark.prove
@pytest.mark.parametrize("angle", [0.0, 0.01, 0.06])
def test_an_angle_beside_tyres_that_creep(angle):
    """It is told where it explains what they leave, also where it is a trifle beside them."""
    found = told(circles(angle, compliance=1 / 60.0))
    assert set(found) == {"lateral_slip", *(["wheel_misalignment"] if angle else [])}
    if angle:
        assert found["wheel_misalignment"]["angle"] == pytest.approx(angle, rel=0.05)


@pytest.mark.long
def test_wheels_that_hold_show_nothing_sideways():
    assert told(circles(seed=3)) == {}
