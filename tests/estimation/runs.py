"""Logs for the estimators' tests, made by an integrator of the tests' own from hand-written reduced dynamics."""

import numpy as np

from cartgrasp.logs import ArmLog, RunLog

STEP = 0.01
SUBSTEPS = 5
CONTACT = np.array([-0.25, 0.1, 1.0])


def reduced_rate(state, fx, tau, cart):
    """Physics 4 by hand, with viscous and Coulomb drag at {b}'s origin; state (x, y, theta, u, r)."""
    m, dx, dy, inertia, linear, angular, coulomb = cart
    _, _, theta, u, r = state
    J = inertia + m * (dx**2 + dy**2)
    drag = linear * u + coulomb * m * 9.81 * np.tanh(u / 0.001)
    right = np.array([fx - drag + m * dx * r**2, tau - angular * r - m * dx * u * r])
    acceleration = np.linalg.solve(np.array([[m, -m * dy], [-m * dy, J]]), right)
    return np.array([u * np.cos(theta), u * np.sin(theta), r, *acceleration])


def push(time, curved=True):
    """Open-loop forward force and moment: accelerate, roll, brake; with curves both ways unless straight."""
    phase = time % 6.0
    forward = np.where(phase < 1.5, 24.0, np.where(phase < 4.5, 6.0, -18.0))
    swing = np.where(phase < 3.0, 1.0, -1.0) * 5.0 * np.sin(2 * np.pi * phase / 1.5)
    return float(forward), float(swing) if curved else 0.0


def simulate(cart, seed=0, duration=12.0, curved=True, noise=(0.0004, 0.005, 0.0)):
    """A log of an open-loop push of a cart (m, dx, dy, I, linear, angular, coulomb), and the truth (n, 5)."""
    random = np.random.default_rng(seed)
    sigma_pose, sigma_velocity, sigma_force = noise
    n = round(duration / STEP)
    state, states, wrenches = np.zeros(5), [], []
    for k in range(n):
        fx, tau = push(k * STEP, curved)
        states.append(state)
        wrenches.append([fx, 0.0, 0.0, 0.0, 0.0, tau + CONTACT[1] * fx])
        for _ in range(SUBSTEPS):
            h = STEP / SUBSTEPS
            k1 = reduced_rate(state, fx, tau, cart)
            k2 = reduced_rate(state + h / 2 * k1, fx, tau, cart)
            k3 = reduced_rate(state + h / 2 * k2, fx, tau, cart)
            k4 = reduced_rate(state + h * k3, fx, tau, cart)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    truth = np.array(states)
    theta, u, r = truth[:, 2:].T
    velocity = np.stack([u * np.cos(theta), u * np.sin(theta), r], axis=1)
    force = np.array([sigma_force] * 3 + [sigma_force / 20] * 3)
    log = RunLog(
        time=np.arange(n) * STEP,
        pose=truth[:, :3] + sigma_pose * random.standard_normal((n, 3)),
        velocity=velocity + sigma_velocity * random.standard_normal((n, 3)),
        arms={"hand": ArmLog(np.tile(CONTACT, (n, 1)), np.array(wrenches) + force * random.standard_normal((n, 6)))},
    )
    return log, truth
