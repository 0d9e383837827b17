"""Logs for the estimators' tests, made by an integrator of the tests' own from hand-written reduced dynamics."""

import math
from functools import lru_cache

import numpy as np

from cartgrasp.logs import ArmLog, RunLog

STEP = 0.01
SUBSTEPS = 5
CONTACT = np.array([-0.25, 0.1, 1.0])


def reduced_rate(state, fx, tau, cart):
    """Physics 4 by hand, with viscous and Coulomb drag at {b}'s origin; state (x, y, theta, u, r)."""
    return np.array(_rate(state, fx, tau, cart))


def _rate(state, fx, tau, cart):
    m, dx, dy, inertia, linear, angular, coulomb = cart
    _, _, theta, u, r = state
    forward = fx - linear * u - coulomb * m * 9.81 * math.tanh(u / 0.001) + m * dx * r**2
    turning = tau - angular * r - m * dx * u * r
    # m u' - m dy r' = forward; -m dy u' + (I + m dx² + m dy²) r' = turning
    bend = (turning + dy * forward) / (inertia + m * dx**2)
    return u * math.cos(theta), u * math.sin(theta), r, forward / m + dy * bend, bend


def push(time, curved=True):
    """Open-loop forward force and moment: accelerate, roll, brake; with curves both ways unless straight."""
    phase = time % 6.0
    forward = 24.0 if phase < 1.5 else 6.0 if phase < 4.5 else -18.0
    swing = (5.0 if phase < 3.0 else -5.0) * math.sin(2 * math.pi * phase / 1.5)
    return forward, swing if curved else 0.0


def pushed(time, state):
    """Forces that curve, whatever the cart does."""
    return push(time)


def pushed_straight(time, state):
    """Those that do not."""
    return push(time, curved=False)


@lru_cache(maxsize=32)
def integrate(cart, forces, duration, change=None):
    """Truth (n, 5) and reduced wrenches (n, 2) of a cart (m, dx, dy, I, linear, angular, coulomb) pushed with
    `forces(time, state) -> (fx, tau)`, held over each step. `change`: a time from which on it is another cart."""
    state, states, wrenches, h = (0.0,) * 5, [], [], STEP / SUBSTEPS

    def moved(rate, step):
        return tuple(s + step * r for s, r in zip(state, rate, strict=True))

    for k in range(round(duration / STEP)):
        if change is not None and k == round(change[0] / STEP):
            cart = change[1]
        fx, tau = map(float, forces(k * STEP, state))
        states.append(state)
        wrenches.append([fx, tau])
        for _ in range(SUBSTEPS):
            k1 = _rate(state, fx, tau, cart)
            k2 = _rate(moved(k1, h / 2), fx, tau, cart)
            k3 = _rate(moved(k2, h / 2), fx, tau, cart)
            k4 = _rate(moved(k3, h), fx, tau, cart)
            state = moved([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], h)
    found = np.array(states), np.array(wrenches)
    for one in found:
        one.flags.writeable = False  # the next one who asks gets the same
    return found


def wrench_rows(time, wrenches, parameters):
    """As in `kernels/measured_wrench.py`: reduced wrenches (n, 2) with noise of 1, whatever the parameters (p,)."""
    n, p = len(time), len(parameters)
    noise, by_parameters = np.tile(np.eye(2).ravel(), (n, 1)), np.zeros((n, 2 * p))
    return np.column_stack([time, wrenches, noise, by_parameters, np.tile(parameters, (n, 1)), np.zeros((n, 2))])


def record(truth, hands, noise, seed):
    """A log with sensor noise (pose, velocity, force) of what each hand gives: contact (3,), wrench (n, 6)."""
    random = np.random.default_rng(seed)
    sigma_pose, sigma_velocity, sigma_force = noise
    n = len(truth)
    theta, u, r = truth[:, 2:].T
    velocity = np.stack([u * np.cos(theta), u * np.sin(theta), r], axis=1)
    force = np.array([sigma_force] * 3 + [sigma_force / 20] * 3)
    return RunLog(
        time=np.arange(n) * STEP,
        pose=truth[:, :3] + sigma_pose * random.standard_normal((n, 3)),
        velocity=velocity + sigma_velocity * random.standard_normal((n, 3)),
        arms={
            name: ArmLog(np.tile(contact, (n, 1)), wrench + force * random.standard_normal((n, 6)))
            for name, (contact, wrench) in hands.items()
        },
    )


def simulate(cart, seed=0, duration=12.0, curved=True, noise=(0.0004, 0.005, 0.0)):
    """A log of an open-loop push of a cart with one hand, and the truth (n, 5)."""
    truth, wrenches = integrate(cart, pushed if curved else pushed_straight, duration)
    wrench = np.zeros((len(truth), 6))
    wrench[:, 0] = wrenches[:, 0]
    wrench[:, 5] = wrenches[:, 1] + CONTACT[1] * wrenches[:, 0]
    return record(truth, {"hand": (CONTACT, wrench)}, noise, seed), truth


def weave(time, state):
    """Two hands' feedback on speed and heading, from rest: forwards and back at times, with many turns."""
    speed = 0.0 if time < 0.5 else 0.35 + 0.35 * math.sin(0.7 * time + 1.0) + 0.1 * math.sin(1.9 * time)
    heading = 0.9 * math.sin(0.5 * time) + 0.35 * math.sin(1.3 * time)
    return 80.0 * (speed - state[3]), 40.0 * (heading - state[2]) - 25.0 * state[4]


def simulate_two_hands(cart, seed=0, duration=30.0, noise=(0.0005, 0.005, 3.0), change=None):
    """A log of a cart pushed by two hands with feedback; the moment is given by unlike forward forces."""
    truth, wrenches = integrate(cart, weave, duration, change)
    hands = {}
    for name, side in (("left", 0.25), ("right", -0.25)):
        wrench = np.zeros((len(truth), 6))
        wrench[:, 0] = wrenches[:, 0] / 2 - wrenches[:, 1] / (2 * side)
        hands[name] = (np.array([-0.4, side, 1.0]), wrench)
    return record(truth, hands, noise, seed)
