"""Balances of motions that are written down: the true cart leaves nothing, and parameters come back."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.effects import (
    CasterRealignment,
    FloorPatch,
    FloorSlope,
    ForceScale,
    LoadSlosh,
    RollingResistance,
    ViscousDrag,
)
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation.weak_form.balances import Balances
from estimation.weak_form.motion import motion_of
from estimation.weak_form.rows import Errors

from ..discrepancy.logs import circles, straight
from .motions import TRUE, cart_of, noisy, weaving

WHEELS = (Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3), Wheel("caster", 0.7, 0.2), Wheel("caster", 0.7, -0.2))
CARTS = st.tuples(
    st.floats(8.0, 80.0),
    st.floats(-0.2, 0.5),
    st.floats(-0.1, 0.1),
    st.floats(0.5, 8.0),
    st.floats(0.0, 10.0),
    st.floats(0.0, 5.0),
)


def size_of(balances, cart):
    """Root mean square of the wrench against the test functions (c,)."""
    return np.sqrt(np.mean(balances.integrated(balances.wrenches.planar(cart) @ cart.basis_b) ** 2, axis=0))


@pytest.mark.long
@settings(max_examples=10, deadline=None)
@given(mass=st.floats(5.0, 80.0), told=st.floats(5.0, 80.0), force=st.floats(2.0, 30.0))
def test_a_constant_force_on_a_mass(mass, told, force):
    """A cubic B-spline's integral is the step from one to the next, so F - m a is left that often, and a unit of mass
    takes a of it."""
    log = straight(acceleration=force / mass, mass=mass)
    cart = CartModel(Inertia(told, (0.0, 0.0), 1.0))
    balances = Balances.of(log, cart)
    left, slopes = balances.residual(cart)
    assert left[:, 0] == pytest.approx((force - told * force / mass) * balances.row_step, abs=1e-6 * force)
    assert slopes[:, 0, 0] == pytest.approx(force / mass * balances.row_step, rel=1e-6)
    assert np.abs(left[:, 1:]).max() < 1e-6 * force


@pytest.mark.long
@settings(max_examples=10, deadline=None)
@given(values=CARTS)
def test_the_true_cart_leaves_nothing(values):
    """A spline of degree 4 with knots h = 0.05 s apart follows sines of w rad/s up to about (w h)^4 of their
    acceleration: 1e-4 for 1.9 rad/s."""
    log, cart = weaving(values), cart_of(values)
    balances = Balances.of(log, cart)
    left, _ = balances.residual(cart)
    assert (np.sqrt(np.mean(left[:, :2] ** 2, axis=0)) < 1e-3 * size_of(balances, cart)).all()
    assert np.abs(left[:, 2]).max() < 1e-4 * balances.row_step


@pytest.mark.long
@settings(max_examples=8, deadline=None)
@given(values=CARTS)
def test_parameters_come_back(values):
    """Balances are linear in phi and drags: one step of least squares from another cart."""
    guess = cart_of((20.0, 0.1, 0.0, 2.0, 1.0, 1.0))
    left, slopes = Balances.of(weaving(values), guess).residual(guess)
    step = np.linalg.lstsq(slopes.reshape(-1, slopes.shape[2]), left.ravel(), rcond=None)[0]
    found, true = guess.parameters + step, cart_of(values).parameters
    usual = np.array([values[0], values[0] * 0.3, values[0] * 0.3, values[3] + values[0] * 0.1, 3.0, 2.0])
    assert (np.abs(found - true) < 1e-3 * usual).all()


def test_slopes_are_what_differences_are():
    """By parameters of a cart, the residual is linear, whether the noise of the motion goes with its own body or
    another's."""
    cart, whole = cart_of(TRUE), Balances.of(noisy(weaving(TRUE), 0), cart_of(TRUE))
    for balances in (whole, whole.beside(cart)):
        left, slopes = balances.residual(cart)
        for i in range(len(cart.parameters)):
            off = np.zeros(len(cart.parameters))
            off[i] = 0.1
            moved, _ = balances.residual(cart.with_parameters(cart.parameters + off))
            assert left - moved == pytest.approx(0.1 * slopes[..., i], abs=1e-9)


@pytest.mark.long
@settings(max_examples=8, deadline=None)
@given(gain=st.floats(0.5, 2.0), left=st.floats(0.2, 0.8))
def test_what_only_the_mass_would_tell_is_a_tie(gain, left):
    """A sensor with a gain, or the other one with its inverse and a body and drags that are as many times heavier: what
    is left is the same, compared by the noise that each has."""
    log = noisy(weaving(TRUE), 0)
    ((_, arm),) = log.arms.items()
    random = np.random.default_rng(0)
    own = {
        name: ArmLog(arm.contact, share * arm.wrench + 0.5 * random.standard_normal(arm.wrench.shape))
        for name, share in (("left", left), ("right", 1.0 - left))
    }
    cart = cart_of(TRUE)
    two = Balances.of(replace(log, arms=own), cart)
    errors = Errors.of(two, cart)
    two = two.beside(cart, errors.heard(*np.full((3, two.n_balances(cart)), 0.1), 1.2))
    body, drag = cart.inertia, ViscousDrag(linear=gain * TRUE[4], angular=gain * TRUE[5])
    heavier = CartModel(
        Inertia(gain * body.mass, body.com, gain * body.about_com), effects=(drag, ForceScale(1 / gain, label="left"))
    )
    one, other = (two.residual(each)[0] for each in (cart.with_effect(ForceScale(gain, label="right")), heavier))
    assert other == pytest.approx(one, abs=1e-6 * np.abs(one).max())


def test_a_column_is_what_its_effect_takes_away():
    """Of a slope of 2 %: the residual without it is the column times its grades."""
    grade = np.array([0.02, -0.01])
    cart, slope = cart_of(TRUE), FloorSlope()
    balances = Balances.of(weaving(TRUE, slope=tuple(grade)), cart)
    left, _ = balances.residual(cart)
    columns = balances.columns(cart, slope)
    assert (left - columns @ grade)[:, :2] == pytest.approx(0.0, abs=1e-3 * np.abs(left).max())
    assert np.abs(left[:, 0]).max() > 0.9 * 9.81 * TRUE[0] * 0.01 * balances.row_step


@pytest.mark.long
@pytest.mark.parametrize("row_step", [0.1, 0.4])
def test_white_noise_of_wrenches_is_what_overlaps_say(row_step):
    """Of densities s: neighbours' covariance is s² times the integral of their test functions' product."""
    random, force = np.random.default_rng(1), 2.0
    still = straight(acceleration=1e-3, duration=300.0)
    arm = still.arms["arm"]
    wrench = arm.wrench + force * random.standard_normal(arm.wrench.shape)
    log = RunLog(still.time, still.pose, still.velocity, {"arm": ArmLog(arm.contact, wrench)})
    cart = CartModel(Inertia(20.0, (0.0, 0.0), 1.0))
    balances = Balances.of(log, cart).every(row_step)
    left, _ = balances.residual(cart)
    row = left[:, 0]
    for lag in (0, 1, 2):
        expected = force**2 * 0.01 * balances.overlap(0, lag)
        found = np.mean(row[: len(row) - lag] * row[lag:])
        assert found == pytest.approx(expected, abs=5 * force**2 * 0.01 * balances.overlap(0, 0) / len(row) ** 0.5)


def test_where_the_cart_stands_no_row_is_used():
    log = weaving(TRUE, 12.0)
    pose, velocity = log.pose.copy(), log.velocity.copy()
    pose[600:] = pose[600]
    velocity[600:] = 0.0
    halted = RunLog(log.time, pose, velocity, log.arms)
    balances = Balances.of(halted, cart_of(TRUE))
    assert balances.time.max() < 6.0 + 2 * balances.row_step + 0.1
    assert len(balances.time) > 50


def test_the_axle_goes_aside_as_its_wheels_are_mounted():
    """At an angle of 0.02 rad it goes aside at 2 % of its speed."""
    cart = CartModel(Inertia(24.0, (0.28, 0.0), 2.2))
    balances = Balances.of(circles(angle=0.02), cart)
    left, _ = balances.residual(cart)
    speed = balances.integrated(balances.motion.velocity[:, 0])
    share = float(speed @ left[:, -1] / (speed @ speed))
    assert share == pytest.approx(np.sin(0.02), abs=2e-4)


@pytest.mark.parametrize("region", [(-0.5, 1.5, -1.0, 0.4), (0.2, 0.4, -9.0, 9.0), (50.0, 51.0, 0.0, 1.0)])
def test_a_patch_is_felt_while_a_wheel_is_on_it(region):
    """Its column is looked for there alone, at every other point: to a hundredth as large as by the whole inverse
    dynamics with it and without."""
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), wheels=WHEELS)
    balances = Balances.of(weaving(TRUE), cart).beside(cart)
    patch = FloorPatch(*region, coefficient=0.0)
    found = balances.columns(cart, patch)[..., -1]
    less, more = (balances.residual(cart.with_effect(replace(patch, coefficient=c)))[0] for c in (0.0, 0.02))
    assert found * 0.02 == pytest.approx(less - more, abs=1e-9 + 0.01 * np.abs(less - more).max())
    assert (np.abs(found).max() > 0.0) == (region[0] < 50.0)


def test_a_lever_is_a_moment_in_proportion_to_the_force():
    """Rolling resistance that acts a metre to the left takes the forward force that it gives as a moment."""
    drag = RollingResistance(0.03)
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2), drag))
    balances = Balances.of(weaving(TRUE), cart).beside(cart)
    found = balances.lever(cart, drag)
    force = balances.residual(cart.without_effect(drag.key))[0][:, 0] - balances.residual(cart)[0][:, 0]
    assert found[:, 1, 0] == pytest.approx(-force, abs=1e-9)
    assert (found[:, [0, 2]] == 0.0).all()


def test_what_effects_remember_is_kept_for_a_motion_and_is_what_it_is():
    """Of a few carts, each twice; and of more than are kept."""
    motion = motion_of(weaving(TRUE), cart_of(TRUE))
    wheels = (Wheel("fixed", 0.0, 0.27), Wheel("caster", 0.7, 0.2, 0.05))
    carts = [
        CartModel(Inertia(24.0, (0.28, 0.05), 2.2), effects=(effect,), wheels=wheels)
        for effect in (RollingResistance(0.01), CasterRealignment(0.3, trail=0.09), LoadSlosh(2.0, 1.3))
    ]
    carts += [carts[0].with_parameters(2 * carts[0].parameters)]
    carts += [carts[2].without_effect("load_slosh").with_effect(LoadSlosh(2.0, 0.5 + 0.1 * i)) for i in range(20)]
    for faster in (0.0, np.array([0.1, -0.2])):
        for cart in (*carts, *carts):
            along = cart.memory_along(motion.pose, motion.velocity + faster, motion.time)
            np.testing.assert_array_equal(motion.memory(cart, faster), along)
    assert motion.memory(carts[3]) is motion.memory(carts[0], np.zeros(2))
    assert motion.memory(carts[2].with_parameters(carts[2].parameters * [1, 1, 1, 1, 3, 1, 1])) is motion.memory(
        carts[2]
    )
