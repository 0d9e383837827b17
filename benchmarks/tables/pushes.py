"""Pushes of a cart on one axle, by inverse dynamics: what was true, before any stranger wrote it down.

With the centre of mass at (d, 0) of {b} and the axle through {b}'s origin, Newton and Euler about that origin give
`fx = m (u' - r² d) + c u + k sign(u)` and `tau = (I + m d²) r' + m d u r + e r`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

RATE = 500.0
CART = """\
name: a cart
mass: {mass}
com: [{way}, 0.0]
inertia: {inertia}
constraints: [no_lateral_slip: {{x: 0.0}}]
effects:
  viscous_drag: {{linear: {drag}, angular: {turning}}}
  rolling_resistance: {{coefficient: {share}}}
"""


@dataclass(frozen=True)
class Hand:
    """Contact point (3,) in {b}, m, and the wrench (n, 6) that it does to the cart."""

    contact: Array
    wrench: Array


@dataclass(frozen=True)
class Push:
    """Times (n,), poses (n, 3) and velocities (n, 3) in the world, hands by name, and the true cart's file."""

    time: Array
    pose: Array
    velocity: Array
    hands: Mapping[str, Hand]
    cart: str

    def at(self, time: Array, columns: Array) -> Array:
        """Columns (n, k) at other times."""
        return np.column_stack([np.interp(time, self.time, column) for column in columns.T])


def drawn_push(random: np.random.Generator, hands: tuple[str, ...], is_line: bool = False) -> Push:
    """Of a drawn cart over a drawn way, from rest to rest; hands share force and turn evenly, with noise on top."""
    duration = random.uniform(15, 40)
    time = np.arange(0, duration, 1 / RATE)
    speed = _speed(random, time)
    rate = np.zeros_like(time) if is_line else _rate(random, time) * (np.abs(speed) > 0.02)
    rate = _smooth(rate, 0.3)
    heading = np.cumsum(rate) / RATE + (0.0 if is_line else random.uniform(-3, 3))
    world = np.column_stack([speed * np.cos(heading), speed * np.sin(heading), rate])
    start = [0.0, 0.0] if is_line else random.uniform(-3, 3, 2)
    pose = np.column_stack([*(start[k] + np.cumsum(world[:, k]) / RATE for k in range(2)), heading])
    fx, tau, cart = _inverse(random, speed, rate)
    return Push(time, pose, world, _shared(random, hands, fx, tau), cart)


def _speed(random: np.random.Generator, time: Array) -> Array:
    """m/s: ramps between drawn speeds, of which some stand still and some go back."""
    knots = np.arange(0, time[-1] + 4, random.uniform(2.0, 4.0))
    speeds = random.uniform(0.15, 1.2, len(knots))
    if random.random() < 0.3:
        speeds[random.random(len(knots)) < 0.3] *= -0.5
    speeds[[0, -1]] = 0.0
    speeds[random.random(len(knots)) < 0.15] = 0.0
    return _smooth(np.interp(time, [0.0, random.uniform(0.5, 1.5), *(knots[1:] + 1)], [0.0, *speeds]), 0.6)


def _rate(random: np.random.Generator, time: Array) -> Array:
    """rad/s: a few waves; a third of the ways hardly turn."""
    size = random.uniform(0.3, 0.9) if random.random() < 0.7 else 0.05
    waves = [np.sin(2 * np.pi * time / random.uniform(4, 15) + random.uniform(0, 6)) for _ in range(2)]
    return np.asarray(size * (waves[0] + 0.5 * waves[1] + random.uniform(-0.5, 0.5)))


def _smooth(column: Array, window: float) -> Array:
    width = round(window * RATE)
    kernel = np.hanning(width + 2)[1:-1]
    padded = np.concatenate([np.full(width, column[0]), column, np.full(width, column[-1])])
    return np.convolve(padded, kernel / kernel.sum(), mode="same")[width:-width]


def _inverse(random: np.random.Generator, speed: Array, rate: Array) -> tuple[Array, Array, str]:
    mass, way = random.uniform(12, 120), random.uniform(0.0, 0.4)
    inertia, drag, turning = mass * random.uniform(0.05, 0.15), random.uniform(1, 8), random.uniform(0.5, 3)
    friction = mass * 9.81 * random.uniform(0.005, 0.02)
    fx = mass * (np.gradient(speed, 1 / RATE) - rate**2 * way) + drag * speed + friction * np.tanh(speed / 0.02)
    tau = (inertia + mass * way**2) * np.gradient(rate, 1 / RATE) + mass * way * speed * rate + turning * rate
    return (
        fx,
        tau,
        CART.format(mass=mass, way=way, inertia=inertia, drag=drag, turning=turning, share=friction / mass / 9.81),
    )


def _shared(random: np.random.Generator, hands: tuple[str, ...], fx: Array, tau: Array) -> dict[str, Hand]:
    """Of two hands the difference of forward forces turns the cart, of one its own moment does."""
    found = {}
    n, behind, height = len(fx), -random.uniform(0.2, 0.6), random.uniform(0.7, 1.1)
    sides = {1: [0.0], 2: [random.uniform(0.15, 0.3)]}[len(hands)] if hands else []
    sides = [sides[0], -sides[0]] if len(hands) == 2 else sides
    for name, side in zip(hands, sides, strict=True):
        wrench = np.zeros((n, 6))
        wrench[:, 0] = fx / len(hands) - (tau / (2 * side) if side else 0.0)
        wrench[:, 5] = 0.0 if side else tau
        time = np.arange(n) / RATE
        wrench[:, 2] = 3 * np.sin(time / 3) - 2
        wrench[:, 3:5] = 0.3 * np.column_stack([np.sin(time / 2), np.cos(time / 5)])
        found[name] = Hand(np.array([round(behind, 3), round(side, 3), round(height, 2)]), wrench)
    return found
