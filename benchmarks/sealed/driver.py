"""A cart driven by arms: feed-forward of the believed cart and feedback of measured speeds, Runge-Kutta between."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .body import find_rate
from .compiling import compiled
from .world import SIZE, R, U

STEPS = 10
"""Of integration between two samples."""
LAG = 0.03
"""s: an arm that is not stepwise follows what it is told with this."""
STRONGEST = 150.0
"""N, over all arms."""


class Belief(NamedTuple):
    """What the controller takes for the cart, and how firmly it holds speeds."""

    mass: float
    com_x: float
    com_y: float
    yaw_inertia: float  # kg m², about {b}'s origin
    linear: float
    angular: float
    gain: float = 4.0  # 1/s
    integral: float = 3.0  # 1/s²


class Drive(NamedTuple):
    """What is asked of the arms, for n instants and k arms."""

    time: np.ndarray  # (n,)
    speeds: np.ndarray  # (n, 4): u, r, u', r' wanted
    contacts: np.ndarray  # (n, k, 3), m
    shares: np.ndarray  # (n, k), of the forward force
    extras: np.ndarray  # (n, k, 6): wrenches on top, with no effect on what is wanted
    errors: np.ndarray  # (n, 2): of the controller's own speed measurement
    held: bool


@compiled
def wanted(speeds, seen, sums, belief):
    """Planar (fx, tau) about {b}'s origin; `sums` are integrals of the errors."""
    m, u, r = belief.mass, speeds[0], speeds[1]
    du = speeds[2] + belief.gain * (u - seen[0]) + belief.integral * sums[0]
    dr = speeds[3] + belief.gain * (r - seen[1]) + belief.integral * sums[1]
    fx = m * (du - belief.com_y * dr - belief.com_x * r * r) + belief.linear * u
    tau = belief.yaw_inertia * dr + m * (belief.com_x * u * r - belief.com_y * du) + belief.angular * r
    return min(max(fx, -STRONGEST), STRONGEST), min(max(tau, -60.0), 60.0)


@compiled
def spread(fx, tau, contacts, shares, extras, out):
    """Wrenches (k, 6) of the arms: shares of the force, half of the moment by their levers, the rest by twists."""
    k = len(shares)
    levers = 0.0
    for i in range(k):
        out[i] = extras[i]
        out[i, 0] += shares[i] * fx
        levers += (contacts[i, 1] - contacts[:, 1].mean()) ** 2
    rest = tau
    for i in range(k):
        rest -= contacts[i, 0] * out[i, 1] - contacts[i, 1] * out[i, 0] + out[i, 5]
    if levers > 0.01:
        for i in range(k):
            pull = -0.5 * rest * (contacts[i, 1] - contacts[:, 1].mean()) / levers
            out[i, 0] += pull
        rest *= 0.5
    for i in range(k):
        out[i, 5] += rest / k


@compiled
def total(contacts, wrenches, height):
    """(fx, fy, tau, fz, pitch) at {b}'s origin; a push above the CoM's `height` presses the front down."""
    out = np.zeros(5)
    for i in range(len(wrenches)):
        p, f = contacts[i], wrenches[i]
        out[0] += f[0]
        out[1] += f[1]
        out[2] += f[5] + p[0] * f[1] - p[1] * f[0]
        out[3] += f[2]
        out[4] += f[4] + (p[2] - height) * f[0] - p[0] * f[2]
    return out


@compiled
def advance(time, state, step, start, end, decay, world):
    """One step; the wrench goes from `start` to `end` by exp(-decay t) (0: it is `end` all the while)."""
    k1, k2, k3, k4 = np.empty(SIZE), np.empty(SIZE), np.empty(SIZE), np.empty(SIZE)
    half = math.exp(-decay * step / 2.0) if decay > 0.0 else 0.0
    full = half * half
    middle, last = end + (start - end) * half, end + (start - end) * full
    first = start if decay > 0.0 else end
    find_rate(time, state, first, world, k1)
    find_rate(time + step / 2.0, state + step / 2.0 * k1, middle, world, k2)
    find_rate(time + step / 2.0, state + step / 2.0 * k2, middle, world, k3)
    find_rate(time + step, state + step * k3, last, world, k4)
    return state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), last


@compiled
def drive_cart(first, drive, belief, world):
    """States (n, SIZE), rates (n, SIZE), wrenches (n, k, 6) at the instants, and what they go to until the next."""
    n, k = drive.shares.shape
    states, rates = np.empty((n, SIZE)), np.empty((n, SIZE))
    wrenches, told = np.zeros((n, k, 6)), np.zeros((n, k, 6))
    sums, seen, state = np.zeros(2), np.zeros(2), first.copy()
    present = np.zeros((k, 6))
    decay = 0.0 if drive.held else 1.0 / LAG
    for i in range(n):
        speeds, contacts = drive.speeds[i], drive.contacts[i]
        seen[0], seen[1] = state[U] + drive.errors[i, 0], state[R] + drive.errors[i, 1]
        step = drive.time[i + 1] - drive.time[i] if i + 1 < n else 0.0
        sums += (speeds[:2] - seen) * step
        fx, tau = wanted(speeds, seen, sums, belief)
        spread(fx, tau, contacts, drive.shares[i], drive.extras[i], told[i])
        if drive.held:
            present[:] = told[i]
        states[i], wrenches[i] = state, present
        start = total(contacts, present, world.com_height)
        end = total(contacts, told[i], world.com_height)
        find_rate(drive.time[i], state, start, world, rates[i])
        time = drive.time[i]
        for _ in range(STEPS):
            state, start = advance(time, state, step / STEPS, start, end, decay, world)
            time += step / STEPS
        present = told[i] + (present - told[i]) * math.exp(-decay * step)
    return states, rates, wrenches, told
