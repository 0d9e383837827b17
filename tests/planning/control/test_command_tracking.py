"""An arm that gives little of what it is told is named, told little, and stood in for; noise, and one that gives, are
not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.simulation import SensorNoise
from planning import Controller, PathReference, chain, pause
from planning.control.command_tracking import (
    IDLE_FRACTION,
    MIN_COMMAND_RMS,
    PROBE_FORCE,
    RETURN_FRACTION,
    CommandTracking,
)
from planning.references import speed_change

from .driving import ticks, without

CART = cg.CartModel(cg.Inertia(40.0, (0.3, 0.0), 3.0), effects=(ViscousDrag(linear=20.0, angular=2.0),))
PATH = PathReference(chain(speed_change(0.8, 0.5), pause(3.0), speed_change(-0.8, 0.5)))


@given(
    share=st.floats(-2.0, 2.0),
    size=st.floats(0.0, 100.0),
    steps=st.lists(st.floats(0.001, 0.05), min_size=60, max_size=60),
)
def test_a_steady_share_is_that_share(share, size, steps):
    """Whatever the rhythm: both means forget alike."""
    watched, told = CommandTracking(), np.array([size, 0.5 * size, 0.0, 1.0, 2.0, 3.0])
    for duration in steps:
        watched = watched.after({"left": told}, {"left": share * told}, duration)
    if watched.lasting["left"] >= 2.0 and np.linalg.norm(told[:3]) > 1.01 * MIN_COMMAND_RMS:
        assert watched.idle == (pytest.approx({"left": share}) if abs(share) < IDLE_FRACTION else {})
    if np.linalg.norm(told[:3]) < MIN_COMMAND_RMS:
        assert not watched.idle


@given(share=st.floats(0.0, 1.0))
def test_one_is_idle_until_it_gives_half_of_the_probe_or_is_told_less(share):
    watched, told = CommandTracking(), {"left": np.full(6, 20.0)}
    probe = np.array([PROBE_FORCE, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(100):
        watched = watched.after(told, {"left": np.zeros(6)}, 0.01)
    for _ in range(300):
        watched = watched.after({"left": probe}, {"left": share * probe}, 0.01)
    assert bool(watched.idle) == (share < RETURN_FRACTION) or abs(share - RETURN_FRACTION) < 1e-3
    for _ in range(300):
        watched = watched.after({"left": 0.4 * probe}, {"left": np.zeros(6)}, 0.01)
    assert not watched.idle


def run(lost, noise=1.0, names=("left",), rate=np.inf, **options):
    """Ticks; from 1.5 to 2.5 s the left arm, or more, gives nothing, and its sensor says so."""
    arms = [
        cg.Arm(n, [(-0.25, y, 1.0)], force_limit=(90.0,) * 3, moment_limit=(9.0,) * 3, wrench_rate=(rate,) * 6)
        for n, y in (("left", 0.2), ("right", -0.2))
    ]
    controller = Controller(CART, arms, PATH, **options)

    def spoiled(felt, given):
        for name in names if lost and 1.5 <= felt.time < 2.5 else ():
            felt, given = without(name, felt, given)
        return felt, given

    felt = SensorNoise(force=noise, moment=0.05 * noise)
    return list(ticks(controller, CART, 4.5, felt, spoiled=spoiled))


def test_a_lost_arm_is_named_and_the_cart_slows_down():
    steps = [tick.step for tick in run(lost=True)]
    named = [step.time for step in steps if step.idle]
    assert 1.5 < named[0] < 1.9
    assert named[-1] < 3.0
    assert {arm for step in steps for arm in step.idle} == {"left"}
    late = next(step for step in steps if step.time > 2.2)
    assert "left is felt to give " in late.words
    assert "slows to 50 % of its speed" in late.words
    assert all(np.isfinite(step.given.wrench_b).all() for step in steps)


@pytest.mark.parametrize("noise", [1.0, 5.0])
def test_arms_that_give_are_not_named(noise):
    assert not any(tick.step.idle for tick in run(lost=False, noise=noise))


def test_others_bear_what_an_idle_arm_does_not():
    """So the cart stays on its path; and the arm is loaded by a ramp when it is back."""
    told = {round(100 * tick.step.time): tick for tick in run(lost=True)}
    steps = {k: tick.step for k, tick in told.items()}
    assert np.linalg.norm(told[249].step.reference.pose_sb[:2] - told[249].motion.pose_sb[:2]) < 0.02
    idle = [step for k, step in steps.items() if step.idle and k < 250]
    assert all(np.linalg.norm(step.wrenches["left"][:3]) <= PROBE_FORCE + 1e-9 for step in idle)
    assert any(step.plan.cart_wrench[0] - step.wrenches["right"][0] < 1e-6 for step in idle)
    forces = np.array([steps[k].wrenches["left"][:3] for k in range(249, 350)])
    assert np.abs(np.diff(forces, axis=0)).max() < 6.0
    assert not steps[320].idle
    assert steps[320].hands["left"].phase == "holds"


@pytest.mark.parametrize("regrasps", [True, False])
def test_arms_that_are_back_give_no_blow(regrasps):
    """Both had been told ever more: four times what the path needs was given at once, and a cart fell over."""
    told = run(lost=True, names=("left", "right"), **({} if regrasps else {"regrasp": None}))
    given = {round(100 * tick.step.time): tick.step.given.wrench_b for tick in told}
    usual = max(np.abs(given[k][0]) for k in range(150))
    assert max(np.abs(given[k][0]) for k in range(250, 420)) < 1.3 * usual
    assert max(np.abs(given[k][0]) for k in range(200, 250)) <= 2.0 * PROBE_FORCE + 1e-9
    assert any(tick.step.words.endswith("no arm gives what it is told") for tick in told)
    last = told[-1]
    assert np.linalg.norm(last.step.reference.pose_sb[:2] - last.motion.pose_sb[:2]) < 0.03


@pytest.mark.some(2)
@pytest.mark.parametrize("options", [{}, {"regrasp": None}])
@pytest.mark.parametrize("names", [("left",), ("left", "right")])
def test_wrenches_of_arms_that_go_and_come_back_change_no_faster_than_they_may(names, options):
    """Down to the probe as up from it."""
    steps = [tick.step for tick in run(lost=True, names=names, rate=100.0, **options)]
    assert any(step.idle for step in steps)
    for name in ("left", "right"):
        given = np.array([step.wrenches[name] for step in steps])
        assert np.abs(np.diff(given, axis=0)).max() <= 100.0 * 0.01 * (1 + 1e-9)


def test_a_sensor_of_the_other_sign_is_no_idle_arm():
    watched, told = CommandTracking(), np.full(6, 20.0)
    for _ in range(100):
        watched = watched.after({"left": told}, {"left": -told}, 0.01)
    assert not watched.idle
