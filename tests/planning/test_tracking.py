"""Tracking laws: with the true model errors vanish, and with a wrong one they are what closed forms say."""

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from cartgrasp.simulation.integrate import runge_kutta_4
from planning.references import PathReference, chain, pause, speed_change, straight, turn
from planning.steering import error_b
from planning.tracking import DirectTracker, Gains, SteeringTracker, build_tracker

BODY = Inertia(20.0, (0.3, 0.1), 2.0)
DRAG = (ViscousDrag(linear=3.0, angular=1.0),)
KINDS = {
    "axle": (RollingConstraints(0.0), 0.6),
    "axle ahead": (RollingConstraints(0.4), 0.6),
    "casters": (RollingConstraints(None), 0.6),
    "rail": (RollingConstraints(no_rotation=True), 0.0),
}


def follow(constraints, start, angle, believed=None, gains=None, step=0.005):
    """Errors (n, 3) of a continuous-time loop, integrated finely with the true model."""
    cart = CartModel(BODY, constraints, DRAG)
    parts = [speed_change(0.5), pause(2.0), *([turn(angle, 0.4)] if angle else []), pause(6.0), speed_change(-0.5)]
    path = PathReference(chain(*parts), constraints)
    tracker = build_tracker(constraints, gains)
    state, errors = cart.state(start), []
    for k in range(int((path.duration - 1.0) / step)):
        time = k * step
        reference = path.at(time)
        errors.append(reference.pose_sb - state[:3])

        def rate(t, y, reference=reference):
            motion = Motion(y[:3], y[cart.velocity_slice])
            return cart.state_rate(y, tracker.wrench_b(path.at(t), motion, believed or cart))

        state = runge_kutta_4(rate, time, state, step)
    return np.array(errors)


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("kind", KINDS)
def test_errors_vanish_with_the_true_model(kind):
    constraints, angle = KINDS[kind]
    sideways = 0.0 if constraints.no_rotation else 0.15
    errors = follow(constraints, (-0.2, sideways, sideways), angle)
    assert np.linalg.norm(errors[0]) > 0.15
    assert np.abs(errors[-1]).max() < 2e-3


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("kind", KINDS)
def test_no_error_grows_from_none(kind):
    """What is left is the integrator's: its last stage sees the next stretch's acceleration, h da / 6 = 4e-4 m/s."""
    constraints, angle = KINDS[kind]
    assert np.abs(follow(constraints, (0, 0, 0), angle)).max() < 4e-4 / Gains().velocity


@pytest.mark.parametrize("heading", [0.8, -2.5])
def test_a_heading_alone_leads_no_cart_on_casters_astray(heading):
    """The reference's velocity is turned from its own axes into the cart's: they were 0.11 and 0.6 m away."""
    errors = follow(RollingConstraints(None), (0.0, 0.0, heading), 0.8, step=0.02)
    assert np.hypot(*errors[:, :2].T).max() < 6e-3
    assert abs(errors[-1, 2]) < 2e-3


@pytest.mark.long
def test_steady_error_of_a_wrong_mass_is_the_closed_form():
    """Accelerating at a with mass m believed m_b: m (a + k_v k_x e) = m_b (a + ...): e = (m - m_b) a / (m_b k_x k_v)
    once settled, on a straight line without drag."""
    constraints, gains = RollingConstraints(0.0), Gains(along=2.0, velocity=4.0)
    cart, believed = CartModel(BODY, constraints), CartModel(Inertia(16.0, BODY.com, 2.0), constraints)
    path = PathReference(chain(straight(40.0, 4.0, 0.5)))
    tracker, state, step = SteeringTracker(gains), cart.state(), 0.005
    for k in range(int(6.0 / step)):

        def rate(t, y):
            motion = Motion(y[:3], y[3:5])
            return cart.state_rate(y, tracker.wrench_b(path.at(t), motion, believed))

        state = runge_kutta_4(rate, k * step, state, step)
    error = path.at(6.0).pose_sb[0] - state[0]
    assert error == pytest.approx((20.0 - 16.0) * 0.5 / (16.0 * 2.0 * 4.0), rel=0.02)


def test_each_constraint_has_its_law():
    assert isinstance(build_tracker(RollingConstraints(0.0)), SteeringTracker)
    assert isinstance(build_tracker(RollingConstraints(None)), DirectTracker)
    assert isinstance(build_tracker(RollingConstraints(no_rotation=True)), DirectTracker)


def test_no_side_force_is_asked_of_a_constrained_cart():
    cart = CartModel(BODY, RollingConstraints(0.2), DRAG)
    reference = PathReference(chain(speed_change(0.5), turn(0.5, 0.3), speed_change(-0.5))).at(1.5)
    wrench = SteeringTracker().wrench_b(reference, Motion(np.array([0.1, 0.2, 0.3]), np.array([0.2, 0.1])), cart)
    assert wrench[1] == 0.0
    assert np.isfinite(wrench).all()


@pytest.mark.some(2)
@pytest.mark.parametrize("axle", [0.0, 0.4])
@pytest.mark.parametrize("start", [(-40.0, 3.0, 2.5), (0.4, -0.8, -1.0), (5.0, 30.0, -3.0)])
def test_far_errors_are_made_good_at_a_bounded_speed(axle, start):
    """A cart that begins as quick as the law wants stays so, and the law's Lyapunov function falls at the rate that is
    claimed of it: nu_c and its derivative agree."""
    cart, gains = CartModel(BODY, RollingConstraints(axle)), Gains(velocity=50.0)
    path = PathReference(chain(speed_change(0.5), pause(20.0), speed_change(-0.5)), cart.constraints)
    tracker, state, step = SteeringTracker(gains), cart.state(start), 0.002
    values, falls, speeds = [], [], []
    for k in range(3000):
        time = 2.0 + k * step

        def rate(t, y):
            return cart.state_rate(y, tracker.wrench_b(path.at(t), Motion(y[:3], y[3:5]), cart))

        x, y, heading = error_b(path.at(time).pose_sb, state[:3], axle)
        longer = np.sqrt(1.0 + (x**2 + y**2) / gains.reach**2)
        values.append(gains.reach**2 * (longer - 1.0) + heading**2 / (2.0 * gains.across))
        turning = heading**2 / np.sqrt(1.0 + heading**2 / gains.reach**2)
        falls.append(-gains.along * (x / longer) ** 2 - gains.heading / gains.across * turning)
        speeds.append(state[3:5])
        state = runge_kutta_4(rate, time, state, step)
    u, r = np.abs(speeds).max(axis=0)
    assert u < 0.5 + gains.along * gains.reach + 1e-3
    assert r < gains.heading * gains.reach + 0.5 * gains.across * gains.reach + 1e-3
    settled = slice(200, None)  # nu is nu_c by then
    slopes = np.gradient(values, step)[settled]
    np.testing.assert_allclose(slopes, np.array(falls)[settled], atol=2e-3 * np.abs(slopes).max())
    assert values[-1] < values[200]


@pytest.mark.some(1)
@pytest.mark.parametrize("kind", ["casters", "rail"])
def test_directly_held_errors_are_made_good_at_a_bounded_speed(kind):
    constraints = KINDS[kind][0]
    cart, gains = CartModel(BODY, constraints, DRAG), Gains()
    path = PathReference(chain(speed_change(0.5), pause(30.0), speed_change(-0.5)), constraints)
    tracker, speeds = DirectTracker(gains), []
    state = cart.state((-8.0, 0.0, 0.0) if constraints.no_rotation else (-6.0, 5.0, 2.0))
    for k in range(2000):

        def rate(t, y):
            return cart.state_rate(y, tracker.wrench_b(path.at(t), Motion(y[:3], y[cart.velocity_slice]), cart))

        speeds.append(np.linalg.norm(state[cart.velocity_slice][:2]))
        state = runge_kutta_4(rate, 2.0 + 0.01 * k, state, 0.01)
    assert max(speeds) < 0.5 + gains.along * gains.reach + 0.05
    assert np.abs(error_b(path.at(22.0).pose_sb, state[:3], 0.0)).max() < 2e-3
