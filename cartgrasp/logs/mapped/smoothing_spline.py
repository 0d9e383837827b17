"""Velocity from noisy positions: the cubic smoothing spline with the least risk at the stated noise.

The spline minimises `sum (y_i - g(t_i))² + lam ∫ g''²`; Reinsch (1967) solves `(R + lam QᵀQ) c = Qᵀ y` for its second
derivatives c, `g = y - lam Q c`. lam minimises the unbiased estimate of risk, `|y - g|² + 2 s² tr(A)` with noise s
(Craven and Wahba, 1979), where `tr(A) = T lam_s^(-1/4) / (2 sqrt 2 h)` with the mean step h is that of even samples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...frames import Array

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

MIN_SPLINE_SAMPLES = 8
MAX_SMOOTHING_DECADE, MIN_SMOOTHING_DECADE = 14.0, -4.0
"""Decades of lam / h³ that are searched."""


def spline_at_noise(time: Array, values: Array, noise: float) -> CubicSpline[np.float64]:
    """The smoothing spline of samples (n,) at increasing times (n,), n >= 3, whose noise has the standard deviation
    `noise`: the natural spline through its own values."""
    from scipy.interpolate import CubicSpline
    from scipy.optimize import minimize_scalar

    step = (time[-1] - time[0]) / (len(time) - 1)
    system = SplineSystem((time - time[0]) / step, values)

    def risk(decade: float) -> float:
        curvature = system.curvature(10.0**decade)
        residual = 10.0**decade * system.spread(curvature)
        return float(residual @ residual + 2 * noise**2 * _freedom(len(time), decade))

    decades = MIN_SMOOTHING_DECADE, MAX_SMOOTHING_DECADE
    best = minimize_scalar(risk, bounds=decades, method="bounded", options={"xatol": 0.02})
    return CubicSpline(time, system.smoothed(10.0**best.x), bc_type="natural")


def _freedom(count: int, decade: float) -> float:
    """tr(A): between 2, a straight line, and as many as there are samples."""
    return float(np.clip(count * 10.0 ** (-decade / 4) / 2**1.5, 2.0, count))


class SplineSystem:
    """R (`stiffness`) and QᵀQ (`roughness`) as upper bands, Q by its three diagonals, and Qᵀ y (`right`): of values
    (n,) at knots (n,) with a mean step of 1."""

    def __init__(self, knots: Array, values: Array) -> None:
        self.values = values
        h = np.diff(knots)
        a, c = 1 / h[:-1], 1 / h[1:]
        b = -(a + c)
        self.diagonals = a, b, c
        self.right = a * values[:-2] + b * values[1:-1] + c * values[2:]
        self.stiffness, self.roughness = np.zeros((3, len(b))), np.zeros((3, len(b)))
        self.stiffness[2] = (h[:-1] + h[1:]) / 3
        self.stiffness[1, 1:] = h[1:-1] / 6
        self.roughness[2] = a * a + b * b + c * c
        self.roughness[1, 1:] = b[:-1] * a[1:] + c[:-1] * b[1:]
        self.roughness[0, 2:] = c[:-2] * a[2:]

    def curvature(self, smoothing: float) -> Array:
        """Second derivatives at the inner knots, (n - 2,)."""
        from scipy.linalg import solveh_banded

        return np.asarray(solveh_banded(self.stiffness + smoothing * self.roughness, self.right))

    def spread(self, curvature: Array) -> Array:
        """Q c, (n,)."""
        found = np.zeros(len(self.values))
        for k, diagonal in enumerate(self.diagonals):
            found[k : len(found) - 2 + k] += diagonal * curvature
        return found

    def smoothed(self, smoothing: float) -> Array:
        """The spline's values at the knots, (n,)."""
        return np.asarray(self.values - smoothing * self.spread(self.curvature(smoothing)))
