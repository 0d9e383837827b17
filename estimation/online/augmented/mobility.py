"""Inertial coordinates in which forward dynamics is linear: what makes the filter consistent.

Accelerations are linear in the inverse of the reduced mass matrix, not in phi. A filter over phi linearises `1/m`
anew at every noisy guess and counts information twice where the guess is low: over noise of 0.05-0.2 m it settles
two to four of its own standard deviations below the mass. In these coordinates it does not (see `tests/estimation`).

With one rolling constraint, and (mass, first moments, J) taken about the axle with x along the wheels' rolling,
`Mr = [[m, -m dy], [-m dy, J]]` and

    (a, b, c, g) = (Mr⁻¹[0,0], Mr⁻¹[0,1], Mr⁻¹[1,1], c m dx),
    m = c/D,  m dx = g/c,  m dy = b/D,  J = a/D,   D = a c - b².

With none, `(1/m, dx/I, dy/I, 1/I)`; on a rail the one thing to know is `1/m`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, final

import numpy as np

from cartgrasp.constraints import RollingConstraints
from cartgrasp.frames import Array, rotation_planar

MOST_COUPLING = 0.9
"""Of b² / (a c): m dy² is at most this share of J."""


@dataclass(frozen=True)
class BodyLimits:
    """What a cart like the first guess can have: ranges (low, high) of mass, CoM and inertia about the CoM, SI."""

    mass: tuple[float, float]
    com_x: tuple[float, float]
    com_y: tuple[float, float]
    inertia: tuple[float, float]

    @cached_property
    def widest_inertia(self) -> float:
        """The largest inertia about {b}'s origin, kg·m²."""
        return self.inertia[1] + self.mass[1] * (max(map(abs, self.com_x)) ** 2 + max(map(abs, self.com_y)) ** 2)


class Chart(Protocol):
    """Coordinates (4,) of phi (4,). `order` names the coordinate behind mass, com_x, com_y and inertia."""

    order: tuple[int, int, int, int]

    def coordinates(self, phi: Array) -> Array: ...

    def phi(self, coordinates: Array) -> Array: ...

    def jacobian(self, coordinates: Array) -> Array:
        """Partials (4, 4) of phi by the coordinates."""
        ...

    def bounds(self, i: int, coordinates: Array, limits: BodyLimits) -> tuple[float, float]:
        """Range of coordinate `i` that keeps the body within limits, given the others (4 and more); in the order of
        `clamped`."""
        ...

    clamped: tuple[int, ...]
    """The coordinates in the order in which bounding them one after the other gives a body within limits."""


def build_chart(constraints: RollingConstraints) -> Chart:
    """The chart that suits the constraints."""
    if constraints.n_rows == 0:
        return FreeChart()
    return RailChart() if constraints.no_rotation else AxleChart(constraints.axle_x or 0.0, constraints.angle)


@final
class AxleChart:
    """One rolling constraint: axle at x = `axle_x`, wheels at `angle` to {b}'s x. The CoM's range turns with them."""

    order = (0, 3, 1, 2)
    clamped: tuple[int, ...] = (2, 1, 0, 3)

    def __init__(self, axle_x: float, angle: float = 0.0) -> None:
        self._axle_x = axle_x
        turn = rotation_planar(-angle)
        _, (self._sine, self._cosine) = turn.tolist()
        # phi about the axle: m dx - m a, and J - 2 a m dx + a² m
        self._to_axle = np.eye(4)
        self._to_axle[1, 0], self._to_axle[3, 0], self._to_axle[3, 1] = -axle_x, axle_x**2, -2 * axle_x
        self._to_axle[1:3] = turn @ self._to_axle[1:3]
        self._from_axle = np.linalg.inv(self._to_axle)

    def coordinates(self, phi: Array) -> Array:
        m, mx, my, J = self._to_axle @ phi
        determinant = m * J - my**2
        return np.array([J / determinant, my / determinant, m / determinant, mx * m / determinant])

    def phi(self, coordinates: Array) -> Array:
        a, b, c, g = coordinates
        determinant = a * c - b**2
        return np.asarray(self._from_axle @ np.array([c / determinant, g / c, b / determinant, a / determinant]))

    def bounds(self, i: int, coordinates: Array, limits: BodyLimits) -> tuple[float, float]:
        a, b, c = coordinates[:3].tolist()
        c = max(c, 1 / limits.widest_inertia)
        least = limits.inertia[0]
        if i == 2:
            return 1 / limits.widest_inertia, 1 / least
        if i == 1:
            most = (MOST_COUPLING * max(a, 0.0) * c) ** 0.5
            low, high = self._com_range(limits)[1]
            return max(low * c, -most), min(high * c, most)
        if i == 0:
            return 1 / limits.mass[1] + b**2 / c, 1 / limits.mass[0] + b**2 / c
        determinant = max(a * c - b**2, c / limits.mass[1])  # mass is c/D
        to_g = c**2 / determinant
        most = c * (max(1 - least * c, 0.0) / determinant) ** 0.5  # I = 1/c - g² D / c³
        low, high = self._com_range(limits)[0]
        return max(low * to_g, -most), min(high * to_g, most)

    def _com_range(self, limits: BodyLimits) -> tuple[tuple[float, float], tuple[float, float]]:
        """Low and high of the CoM along and across the wheels, from the axle."""
        (back, front), (right, left) = limits.com_x, limits.com_y
        x, y = (back + front) / 2 - self._axle_x, (right + left) / 2
        along, across = self._cosine * x - self._sine * y, self._sine * x + self._cosine * y
        reach, width = (front - back) / 2, (left - right) / 2
        return (along - reach, along + reach), (across - width, across + width)

    def jacobian(self, coordinates: Array) -> Array:
        a, b, c, g = coordinates
        determinant = a * c - b**2
        by_determinant = np.array([-c, 0.0, -b, -a]) / determinant**2
        partials = np.outer(by_determinant, [c, -2 * b, a, 0.0])
        partials[0, 2] += 1 / determinant
        partials[2, 1] += 1 / determinant
        partials[3, 0] += 1 / determinant
        partials[1, 2], partials[1, 3] = -g / c**2, 1 / c
        return np.asarray(self._from_axle @ partials)


@final
class FreeChart:
    """No rolling constraint."""

    order = (0, 1, 2, 3)
    clamped: tuple[int, ...] = (0, 3, 1, 2)

    def coordinates(self, phi: Array) -> Array:
        m, mx, my, J = phi
        about_com = J - (mx**2 + my**2) / m
        return np.array([1 / m, mx / (m * about_com), my / (m * about_com), 1 / about_com])

    def phi(self, coordinates: Array) -> Array:
        k, p, q, c = coordinates
        return np.array([1 / k, p / (c * k), q / (c * k), 1 / c + (p**2 + q**2) / (c**2 * k)])

    def bounds(self, i: int, coordinates: Array, limits: BodyLimits) -> tuple[float, float]:
        c = max(coordinates[3], 1 / limits.inertia[1])
        low, high = (limits.mass, limits.com_x, limits.com_y, limits.inertia)[i]
        return (low * c, high * c) if i in (1, 2) else (1 / high, 1 / low)

    def jacobian(self, coordinates: Array) -> Array:
        k, p, q, c = coordinates
        square = p**2 + q**2
        return np.array(
            [
                [-1 / k**2, 0.0, 0.0, 0.0],
                [-p / (c * k**2), 1 / (c * k), 0.0, -p / (c**2 * k)],
                [-q / (c * k**2), 0.0, 1 / (c * k), -q / (c**2 * k)],
                [
                    -square / (c**2 * k**2),
                    2 * p / (c**2 * k),
                    2 * q / (c**2 * k),
                    -1 / c**2 - 2 * square / (c**3 * k),
                ],
            ]
        )


@final
class RailChart:
    """A cart on a rail: 1/m; the rest of phi stays as it is."""

    order = (0, 1, 2, 3)
    clamped: tuple[int, ...] = (0,)

    def coordinates(self, phi: Array) -> Array:
        return np.array([1 / phi[0], *phi[1:]])

    def phi(self, coordinates: Array) -> Array:
        return np.array([1 / coordinates[0], *coordinates[1:]])

    def bounds(self, i: int, coordinates: Array, limits: BodyLimits) -> tuple[float, float]:
        return 1 / limits.mass[1], 1 / limits.mass[0]

    def jacobian(self, coordinates: Array) -> Array:
        return np.diag([-1 / coordinates[0] ** 2, 1.0, 1.0, 1.0])
