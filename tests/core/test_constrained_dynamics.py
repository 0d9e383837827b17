"""The reduced dynamics against the paper's full constrained form, in world components (physics.md).

This file knows nothing of S, nu or the body-frame matrices. It takes the kinetic energy (1) and derives (2)
from it by complex steps, writes the constraints (3) as velocities of a point of the axle, and solves (4) with
its multipliers:

    [M  Λᵀ] [ qdd ]   [Γ - c(q, qd)]
    [Λ  0 ] [ -λ' ] = [  -Λdot qd   ],    λ' = -λ of (4): the force of the constraint on the cart.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import solve_ivp

from cartgrasp.effects import (
    CasterRealignment,
    FloorSlope,
    QuadraticDrag,
    RollingResistance,
    StribeckFriction,
    ViscousDrag,
    WheelMisalignment,
)
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.rigid_body import bias_b, mass_matrix_b

from .drawn import CONSTRAINTS, SHOPPING_CART, inertias, numbers, poses, vectors, wrenches

every_cart = pytest.mark.parametrize("constraints", CONSTRAINTS.values(), ids=CONSTRAINTS.keys())


def kinetic_energy(inertia, theta, qd):
    """(1), term by term; `theta` and `qd` may be complex."""
    m, (dx, dy), about_com = inertia.mass, inertia.com, inertia.about_com
    x, y, w = qd
    s, c = np.sin(theta), np.cos(theta)
    return (
        m / 2 * (x**2 + y**2)
        - m * dx * w * (x * s - y * c)
        - m * dy * w * (x * c + y * s)
        + m / 2 * w**2 * (dx**2 + dy**2)
        + about_com / 2 * w**2
    )


def momentum(inertia, theta, qd):
    """dT/dqd; T is quadratic in qd, so the polar form of it is exact, also for complex arguments."""
    return np.array(
        [(kinetic_energy(inertia, theta, qd + e) - kinetic_energy(inertia, theta, qd - e)) / 2 for e in np.eye(3)]
    )


def mass_matrix(inertia, theta):
    return np.column_stack([momentum(inertia, theta, e) for e in np.eye(3)])


def bias(inertia, theta, qd):
    """(d/dt dT/dqd - dT/dq) at qdd = 0, by complex steps in theta, which are exact to rounding."""
    h = 1e-30
    along = momentum(inertia, theta + 1j * h * qd[2], qd).imag / h
    by_theta = kinetic_energy(inertia, theta + 1j * h, qd).imag / h
    return along - np.array([0, 0, by_theta])


def rows(constraints, theta):
    """Velocity of the axle's middle, at (a, 0) of {b}, across the wheels; and the yaw rate on a rail."""
    found = []
    if constraints.axle_x is not None:
        s, c = np.sin(theta), np.cos(theta)
        point = np.array([[1, 0, -constraints.axle_x * s], [0, 1, constraints.axle_x * c]])
        found.append(np.array([-np.sin(theta + constraints.angle), np.cos(theta + constraints.angle)]) @ point)
    if constraints.no_rotation:
        found.append(np.array([0, 0, 1], dtype=np.result_type(theta, float)))
    return np.array(found).reshape(-1, 3)


def rows_rate(constraints, theta, yaw_rate):
    """By a complex step, which is exact to rounding."""
    return rows(constraints, theta + 1e-30j * yaw_rate).imag / 1e-30


def solve_kkt(inertia, constraints, theta, qd, wrench_s):
    """(qdd, constraint forces)."""
    Lambda, Lambda_rate = rows(constraints, theta), rows_rate(constraints, theta, qd[2])
    k = len(Lambda)
    matrix = np.block([[mass_matrix(inertia, theta), -Lambda.T], [Lambda, np.zeros((k, k))]])
    right = np.concatenate([wrench_s - bias(inertia, theta, qd), -Lambda_rate @ qd])
    solution = np.linalg.solve(matrix, right)
    return solution[:3], solution[3:]


def to_world(theta, planar):
    turned = complex(planar[0], planar[1]) * np.exp(1j * theta)
    return np.array([turned.real, turned.imag, planar[2]])


def body_velocity(constraints, nu):
    """(u, w, r), with w = -a r at the origin when the axle, at x = a, does not slip; turned with the wheels."""
    if constraints.axle_x is None:
        return np.array(nu)
    r = 0.0 if constraints.no_rotation else nu[1]
    along, across = nu[0] * np.cos(constraints.angle), nu[0] * np.sin(constraints.angle)
    return np.array([along, across - constraints.axle_x * r, r])


@every_cart
@given(inertia=inertias(), pose=poses(), velocity=vectors(3, -2, 2), wrench_b=wrenches())
def test_acceleration_is_that_of_the_constrained_equations(constraints, inertia, pose, velocity, wrench_b):
    """qdd = d/dt (R v_b) = R (v_b' + r ẑ x v_b); tolerance: rounding through a solve of condition 1e3."""
    check_acceleration(CartModel(inertia, constraints), pose, velocity[: constraints.n_free], wrench_b)


@pytest.mark.parametrize("kind", [kind for kind in CONSTRAINTS if kind != "casters only"])
@given(
    inertia=inertias(),
    pose=poses(),
    velocity=vectors(3, -2, 2),
    wrench_b=wrenches(),
    angle=numbers(-0.5, 0.5),
)
def test_acceleration_with_wheels_at_an_angle(kind, inertia, pose, velocity, wrench_b, angle):
    constraints = CONSTRAINTS[kind]
    cart = CartModel(inertia, constraints, (WheelMisalignment(angle),))
    check_acceleration(cart, pose, velocity[: constraints.n_free], wrench_b)


def check_acceleration(cart, pose, nu, wrench_b):
    inertia, constraints = cart.inertia, cart.rolling
    velocity_b = body_velocity(constraints, nu)
    theta, qd = pose[2], to_world(pose[2], velocity_b)
    rate = cart.rate(cart.state(pose, nu), wrench_b).value
    np.testing.assert_allclose(rate[:3], qd, atol=1e-12)

    u, w, r = velocity_b
    turning = np.array([-w * r, u * r, 0.0])
    qdd = to_world(theta, body_velocity(constraints, rate[3:]) + turning)
    expected, _ = solve_kkt(inertia, constraints, theta, qd, to_world(theta, wrench_b))
    np.testing.assert_allclose(qdd, expected, rtol=1e-9, atol=1e-9)
    Lambda, Lambda_rate = rows(constraints, theta), rows_rate(constraints, theta, r)
    np.testing.assert_allclose(Lambda @ qdd + Lambda_rate @ qd, 0, atol=1e-9)


@given(inertia=inertias(), pose=poses(), velocity=vectors(2, -2, 2), wrench_b=wrenches())
def test_lateral_force_of_the_axle(inertia, pose, velocity, wrench_b):
    """physics.md: `m (u r + dx r' - dy r²) - fy` is the multiplier of the constrained equations."""
    constraints = CONSTRAINTS["axle at the origin"]
    cart = CartModel(inertia, constraints)
    r_rate = cart.rate(cart.state(pose, velocity), wrench_b).value[4]
    u, r = velocity
    lateral = inertia.mass * (u * r + inertia.com[0] * r_rate - inertia.com[1] * r**2) - wrench_b[1]
    qd = to_world(pose[2], [u, 0.0, r])
    _, forces = solve_kkt(inertia, constraints, pose[2], qd, to_world(pose[2], wrench_b))
    np.testing.assert_allclose(lateral, forces[0], rtol=1e-9, atol=1e-9)


@given(inertia=inertias(), pose=poses(), velocity=vectors(3, -2, 2))
def test_body_matrices_are_the_worlds_turned(inertia, pose, velocity):
    """M_b = Rᵀ M R and the body bias is Rᵀ of (bias + M Ṙ v_b)."""
    theta, velocity_b = pose[2], velocity
    R = np.column_stack([to_world(theta, e) for e in np.eye(3)])
    M = mass_matrix(inertia, theta)
    np.testing.assert_allclose(mass_matrix_b(inertia.phi), R.T @ M @ R, atol=1e-11)
    u, w, r = velocity_b
    expected = R.T @ (bias(inertia, theta, R @ velocity_b) + M @ to_world(theta, [-w * r, u * r, 0]))
    np.testing.assert_allclose(bias_b(velocity_b, inertia.phi)[0], expected, atol=1e-10)


@given(inertia=inertias(), velocity=vectors(3, -2, 2))
def test_inertial_forces_do_no_work(inertia, velocity):
    """Mdot - 2 C is skew: in the body frame M is constant, so v · bias = 0."""
    value, _ = bias_b(velocity, inertia.phi)
    np.testing.assert_allclose(value @ velocity, 0, atol=1e-12 * (1 + np.abs(value * velocity).sum()))


@pytest.mark.parametrize("axle", ["axle at the origin", "axle ahead", "axle behind"])
@given(inertia=inertias(), nu=vectors(2, -2, 2))
def test_reduced_matrices_of_one_row(axle, inertia, nu):
    """physics.md, told from the axle: with d measured from there, Mr = [[m, -m dy], [-m dy, J]],
    Cr = m dx r [[0, -1], [1, 0]] (skew, as Mrdot = 0), det Mr = m (I + m dx²) > 0."""
    constraints = CONSTRAINTS[axle]
    m, (dx, dy), about_com = inertia.mass, inertia.com, inertia.about_com
    dx = dx - constraints.axle_x
    S = constraints.basis_b
    Mr = S.T @ mass_matrix_b(inertia.phi) @ S
    J = about_com + m * (dx**2 + dy**2)
    np.testing.assert_allclose(Mr, [[m, -m * dy], [-m * dy, J]], atol=1e-11)
    np.testing.assert_allclose(np.linalg.det(Mr), m * (about_com + m * dx**2), rtol=1e-9)
    Cr = m * dx * nu[1] * np.array([[0, -1], [1, 0]])
    np.testing.assert_allclose(S.T @ bias_b(S @ nu, inertia.phi)[0], Cr @ nu, atol=1e-10)


@every_cart
def test_energy_balance_of_a_run(constraints):
    """T(t) - T(0) is the work of the arms, of the effects and of nobody else, over 2 s with all at once."""
    effects = (
        ViscousDrag(3.0, 1.0),
        RollingResistance(0.02),
        StribeckFriction(4.0, 0.1),
        QuadraticDrag(2.0),
        FloorSlope(0.02, -0.01),
        CasterRealignment(0.2),
    )
    cart = CartModel(Inertia(24.0, (0.36, 0.1), 2.0), constraints, effects, SHOPPING_CART)

    def wrench_b(t):
        return np.array([20 * np.cos(2 * t), 8 * np.sin(3 * t), 5 * np.sin(t)])

    def rate(t, state_and_work):
        state = state_and_work[:-1]
        velocity_b = body_velocity(constraints, state[cart.velocity_slice])
        power = (wrench_b(t) + cart.effect_wrench(state)) @ velocity_b
        return np.append(cart.rate(state, wrench_b(t)).value, power)

    start = np.append(cart.state((0, 0, 0.3), [0.5, 0.4, -0.3][: constraints.n_free]), 0.0)
    run = solve_ivp(rate, (0, 2), start, method="LSODA", rtol=1e-8, atol=1e-10)

    def energy(state):
        qd = to_world(state[2], body_velocity(constraints, state[cart.velocity_slice]))
        return kinetic_energy(cart.inertia, state[2], qd)

    energies = np.array([energy(state) for state in run.y.T])
    np.testing.assert_allclose(energies - energies[0], run.y[-1], atol=1e-6)
    assert np.ptp(energies) > 0.5  # J


def test_the_term_that_the_paper_drops_is_metres():
    """physics.md, under the wrench that holds a circle of u = 1 m/s, r = 0.3 rad/s: with Λ qdd = 0 instead of
    -Λdot qd the cart is metres off after 10 s; with the term both roads end where the circle does."""
    inertia, constraints = Inertia(20.0, (0.3, 0.0), 2.0), CONSTRAINTS["axle at the origin"]
    wrench_b = 20.0 * 0.3 * np.array([-(0.3**2), 0.0, 1.0 * 0.3])

    def rate(_, state, keeps_term):
        theta, qd = state[2], state[3:]
        Lambda = rows(constraints, theta)
        Lambda_rate = rows(constraints, theta + 1e-30j * qd[2]).imag / 1e-30
        matrix = np.block([[mass_matrix(inertia, theta), -Lambda.T], [Lambda, np.zeros((1, 1))]])
        right = np.append(to_world(theta, wrench_b) - bias(inertia, theta, qd), -keeps_term * (Lambda_rate @ qd))
        return np.concatenate([qd, np.linalg.solve(matrix, right)[:3]])

    def end(keeps_term):
        start = [0.0, 0.0, 0.0, 1.0, 0.0, 0.3]
        return solve_ivp(rate, (0, 10), start, args=(keeps_term,), rtol=1e-8, atol=1e-10).y[:3, -1]

    cart = CartModel(inertia, constraints)
    state = cart.state(velocity=[1.0, 0.3])
    run = solve_ivp(lambda _, s: cart.rate(s, wrench_b).value, (0, 10), state, rtol=1e-8, atol=1e-10)
    circle = [np.sin(3.0) / 0.3, (1 - np.cos(3.0)) / 0.3, 3.0]
    np.testing.assert_allclose(run.y[:3, -1], circle, atol=1e-6)
    np.testing.assert_allclose(end(1.0), circle, atol=1e-6)
    assert np.hypot(*(end(0.0) - circle)[:2]) > 5.0
