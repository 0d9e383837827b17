"""Velocity from noisy positions: the cubic smoothing spline with the least risk at the stated noise.

The spline minimises `sum (y_i - g(t_i))² + lam ∫ g''²`; Reinsch (1967) solves `(R + lam QᵀQ) c = Qᵀ y` for its second
derivatives c, `g = y - lam Q c`. lam minimises the unbiased estimate of risk, `|y - g|² + 2 s² tr(A)` with noise s
(Craven and Wahba, 1979), where `tr(A) = T lam_s^(-1/4) / (2 sqrt 2 h)` with the mean step h is that of even samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...frames import Array

MIN_SPLINE_SAMPLES = 8
MAX_SMOOTHING_DECADE, MIN_SMOOTHING_DECADE = 14.0, -4.0
"""Decades of lam / h³ that are searched."""


@dataclass(frozen=True)
class Spline:
    """Knots (n,), values (n,) and slopes (n,) there."""

    knots: Array
    value: Array
    slope: Array

    def slope_at(self, time: Array) -> Array:
        from scipy.interpolate import CubicHermiteSpline

        return np.asarray(CubicHermiteSpline(self.knots, self.value, self.slope).derivative()(time))


def spline_at_noise(time: Array, values: Array, noise: float) -> Spline:
    """The smoothing spline of samples (n,) at increasing times (n,), n >= 3, whose noise has the standard deviation
    `noise`."""
    from scipy.optimize import minimize_scalar

    step = (time[-1] - time[0]) / (len(time) - 1)
    system = SplineSystem((time - time[0]) / step, values)

    def risk(decade: float) -> float:
        curvature = system.curvature(10.0**decade)
        residual = 10.0**decade * system.spread(curvature)
        return float(residual @ residual + 2 * noise**2 * _freedom(len(time), decade))

    decades = MIN_SMOOTHING_DECADE, MAX_SMOOTHING_DECADE
    best = minimize_scalar(risk, bounds=decades, method="bounded", options={"xatol": 0.02})
    knots, value, slope = system.spline(10.0**best.x)
    return Spline(time[0] + step * knots, value, slope / step)


def _freedom(count: int, decade: float) -> float:
    """tr(A): between 2, a straight line, and as many as there are samples."""
    return float(np.clip(count * 10.0 ** (-decade / 4) / 2**1.5, 2.0, count))


class SplineSystem:
    """R (`stiffness`) and QᵀQ (`roughness`) as upper bands, Q by its three diagonals, and Qᵀ y (`right`): of values
    (n,) at knots (n,) with a mean step of 1."""

    def __init__(self, knots: Array, values: Array) -> None:
        self.knots, self.values = knots, values
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
        found = np.zeros(len(self.knots))
        for k, diagonal in enumerate(self.diagonals):
            found[k : len(found) - 2 + k] += diagonal * curvature
        return found

    def spline(self, smoothing: float) -> tuple[Array, Array, Array]:
        curvature = self.curvature(smoothing)
        value = self.values - smoothing * self.spread(curvature)
        second = np.concatenate([[0.0], curvature, [0.0]])
        h = np.diff(self.knots)
        secant = np.diff(value) / h
        slope = np.append(secant, secant[-1])
        slope[:-1] -= h * (2 * second[:-1] + second[1:]) / 6
        slope[-1] += h[-1] * (second[-2] + 2 * second[-1]) / 6
        return self.knots, value, slope
