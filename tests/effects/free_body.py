"""A cart with an axle, and a point mass between it and the arm that pushes: the tests' own equations and integrator."""

from __future__ import annotations

import numpy as np

from cartgrasp.logs import ArmLog, RunLog

G = 9.81
STEP, SUBSTEPS = 0.01, 5


def turned(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def rates(state, push, cart, tool, contact):
    """(u', r') of a cart (m, dx, dy, I, drag, angular drag) and a tool (m, x, y, z) that move as one, by Lagrange's
    equations, where the arm pushes the tool with (fx, fy, tau about the contact)."""
    m, dx, dy, inertia, linear, angular = cart
    mass, *place = tool
    qx, qy = contact[0] + place[0], contact[1] + place[1]
    u, r = state[3:]
    fx, fy, tau = push
    M = np.array([[m + mass, -m * dy - mass * qy], [0.0, inertia + m * (dx**2 + dy**2) + mass * (qx**2 + qy**2)]])
    M[1, 0] = M[0, 1]
    first = m * dx + mass * qx
    right = np.array(
        [fx - linear * u + first * r**2, tau - contact[1] * fx + contact[0] * fy - angular * r - first * u * r]
    )
    return np.linalg.solve(M, right)


def driven(pushes, cart, tool, contacts):
    """States (n, 5) (x, y, theta, u, r) and accelerations (n, 2) under pushes (n, 3) at contacts (n, 3), each held for
    a step."""
    state, states, accelerations = np.zeros(5), [], []

    def rate(state, push, contact):
        u, r = state[3:]
        return np.array([u * np.cos(state[2]), u * np.sin(state[2]), r, *rates(state, push, cart, tool, contact)])

    for push, contact in zip(pushes, contacts, strict=True):
        states.append(state)
        accelerations.append(rates(state, push, cart, tool, contact))
        h = STEP / SUBSTEPS
        for _ in range(SUBSTEPS):
            k1 = rate(state, push, contact)
            k2 = rate(state + h / 2 * k1, push, contact)
            k3 = rate(state + h / 2 * k2, push, contact)
            k4 = rate(state + h * k3, push, contact)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.array(states), np.array(accelerations)


def pushes(time):
    """Accelerate, roll, brake, with curves both ways, (n, 3)."""
    phase = time % 6.0
    forward = np.select([phase < 1.5, phase < 4.5], [24.0, 6.0], -18.0)
    swing = np.where(phase < 3.0, 1.0, -1.0) * 5.0 * np.sin(2 * np.pi * phase / 1.5)
    return np.column_stack([forward, 0.2 * swing, swing])


def recorded(states, contacts, wrenches, noise, seed=1):
    """A log with noise (m or rad, m/s or rad/s, N, and N·m) of what one hand, `hand`, is told to give, (n, 3)."""
    random = np.random.default_rng(seed)
    n, (of_pose, of_velocity, of_force, of_moment) = len(states), noise
    theta, u, r = states[:, 2:].T
    velocity = np.column_stack([u * np.cos(theta), u * np.sin(theta), r])
    spatial = np.zeros((n, 6))
    spatial[:, [0, 1, 5]] = wrenches
    spatial += random.standard_normal((n, 6)) * np.repeat([of_force, of_moment], 3)
    return RunLog(
        time=STEP * np.arange(n),
        pose=states[:, :3] + of_pose * random.standard_normal((n, 3)),
        velocity=velocity + of_velocity * random.standard_normal((n, 3)),
        arms={"hand": ArmLog(contacts, spatial)},
    )
