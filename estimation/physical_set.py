"""The most likely parameters that a cart can have: a quadratic cost, bounds, and a linear matrix inequality.

A body is physical when its planar pseudo-inertia is positive definite (physics.md). With the second moments' trace J,
that is `[[m, m dᵀ], [m d, J 1]] > 0`: by Schur's complement, `J m > |m d|²`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from operator import gt, lt
from typing import Any

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

MIN_MASS_RATIO, MIN_INERTIA_RATIO = 0.1, 0.05
BOUND_MARGIN = 1e-6
"""How far inside its bounds a solution is put, as a share of the first guess."""


@dataclass(frozen=True)
class PhysicalSet:
    """What a cart like the first guess can have: at least `mass` (kg) and `about_com` (kg m²), and effects within
    their bounds (p - 4,). `source` names the data, for errors."""

    mass: float
    about_com: float
    lower: Array
    upper: Array
    turns: bool
    source: str

    @classmethod
    def of(cls, cart: CartModel, source: str) -> PhysicalSet:
        bounds = [(p.lower, p.upper) for effect in cart.effects for p in effect.parameters]
        lower, upper = np.array(bounds).reshape(-1, 2).T
        body = cart.inertia
        least = MIN_MASS_RATIO * body.mass, MIN_INERTIA_RATIO * body.about_com
        return cls(*least, lower, upper, not cart.constraints.no_rotation, source)

    @cached_property
    def _bounds(self) -> tuple[list[float], list[float]]:
        return self.lower.tolist(), self.upper.tolist()

    def holds(self, parameters: Array) -> bool:
        mass, x, y, about_origin, *effects = parameters.tolist()
        lower, upper = self._bounds
        if mass < self.mass or any(map(lt, effects, lower)) or any(map(gt, effects, upper)):
            return False
        return not self.turns or about_origin - (x * x + y * y) / mass >= self.about_com

    def nearest(self, parameters: Array, free: np.ndarray, information: Array) -> Array:
        """The parameters (p,) in the set with the least `|free ones' distance|²` in the metric of the information
        (f, f)."""
        if self.holds(parameters):
            return parameters
        if not (np.isfinite(parameters).all() and np.isfinite(information).all()):
            raise self._none()
        scale = 1 / np.sqrt(np.diagonal(information))
        lift = np.zeros((len(parameters), len(free)))
        lift[free, range(len(free))] = scale
        try:
            quick = self._quickly(parameters, lift, information * np.outer(scale, scale))
            return self._surely(parameters, free, (lift, information)) if quick is None else quick
        except np.linalg.LinAlgError as error:  # numbers so far apart that an information is rounded to none
            raise self._none() from error

    def _quickly(self, parameters: Array, lift: Array, metric: Array) -> Array | None:
        """The nearest parameters as in `nearest`, by steps times `lift` (p, f): by bounds alone, or with one smooth
        limit beside them. None where that does not settle."""
        from scipy.optimize import Bounds, minimize

        low, high = np.full(len(parameters), -np.inf), np.full(len(parameters), np.inf)
        low[0], low[N_PHI:], high[N_PHI:] = (1 + BOUND_MARGIN) * self.mass, self.lower, self.upper
        which, scale = lift.argmax(axis=0), lift.max(axis=0)
        limits = [((edge - parameters)[which] / scale) for edge in (low, high)]
        step = _least(metric, *limits)
        nearest = self._bounded(parameters + lift @ step)
        if not self.holds(nearest):
            size = self._expected_size(metric, step, self._body(parameters[:N_PHI], lift[:N_PHI]))
            found = minimize(  # type: ignore[call-overload]
                lambda step: float(step @ metric @ step),
                step / size,
                jac=lambda step: np.asarray(2 * metric @ step),
                bounds=Bounds(*(limit / size for limit in limits)),
                constraints=self._body(parameters[:N_PHI], size * lift[:N_PHI]),
                method="SLSQP",
                tol=1e-12,
            )
            nearest = self._bounded(parameters + size * lift @ found.x)
            if not found.success:
                return None
        return nearest if self.holds(nearest) else None

    @staticmethod
    def _expected_size(metric: Array, step: Array, body: dict[str, Any]) -> float:
        """About how large the nearest step is: with this one (f,), and straight on by what a body then lacks. Steps of
        that size have a cost of one, by which SLSQP knows where rounding begins."""
        lacks, slope = body["fun"](step)[0], body["jac"](step)
        return float(np.sqrt(step @ metric @ step + lacks**2 / (slope @ slope)))

    def _body(self, phi: Array, lift: Array) -> dict[str, Any]:
        """The constraint on a step that the moment of inertia about the CoM is large enough, by Schur's complement."""

        def spare(step: Any) -> Array:
            mass, x, y, inertia = phi + lift @ step
            return np.array([inertia - (1 + BOUND_MARGIN) * self.about_com - (x * x + y * y) / mass])

        def slope(step: Any) -> Array:
            mass, x, y, _ = phi + lift @ step
            return np.asarray(np.array([(x * x + y * y) / mass**2, -2 * x / mass, -2 * y / mass, 1.0]) @ lift)

        return {"type": "ineq", "fun": spare, "jac": slope}

    def _bounded(self, parameters: Array) -> Array:
        nearest = parameters.copy()
        nearest[N_PHI:] = np.clip(nearest[N_PHI:], self.lower, self.upper)
        return nearest

    def _surely(self, parameters: Array, free: np.ndarray, metric: tuple[Array, Array]) -> Array:
        """The nearest parameters by a cone program, which proves what it finds."""
        import cvxpy as cp

        lift, information = metric
        scale = lift.max(axis=0)
        root = np.linalg.cholesky(information * np.outer(scale, scale)).T
        step = cp.Variable(len(free))
        found = parameters + lift @ step
        limits = [found[0] >= (1 + BOUND_MARGIN) * self.mass]
        if self.turns:
            moments = cp.reshape(found[1:3], (2, 1), order="C")
            second = (found[3] - (1 + BOUND_MARGIN) * self.about_com) * np.eye(2)
            limits.append(cp.bmat([[cp.reshape(found[0], (1, 1), order="C"), moments.T], [moments, second]]) >> 0)
        of_effects = [int(i) for i in free - N_PHI if i >= 0]
        limits += [found[N_PHI + i] >= self.lower[i] for i in of_effects if np.isfinite(self.lower[i])]
        limits += [found[N_PHI + i] <= self.upper[i] for i in of_effects if np.isfinite(self.upper[i])]
        problem = cp.Problem(cp.Minimize(cp.sum_squares(root @ step)), limits)
        try:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Solution may be inaccurate")  # the next round starts from it
                problem.solve(solver=cp.CLARABEL)
        except (cp.SolverError, ValueError) as error:  # the latter where its data overflow
            raise self._none() from error
        if step.value is None:
            raise self._none()
        return self._bounded(parameters + lift @ step.value)

    def _none(self) -> DataError:
        why = "no physical cart could be fitted; look in the log and the cart file for numbers that are not in SI units"
        return DataError(f"{self.source}: {why}")


def _least(metric: Array, low: Array, high: Array) -> Array:
    """The step (f,) within bounds that is least in a metric (f, f): bounds that it meets are taken in, and let go where
    they would pull, until neither is left (a primal-dual active set; rarely it runs in circles)."""
    from scipy.optimize import lsq_linear

    step, meets = np.zeros(len(low)), np.zeros(len(low), dtype=bool)
    for _ in range(2 * len(low)):
        pulls = metric @ step
        held = meets & np.where(step <= low, pulls > 0, pulls < 0)
        now = held | (step < low) | (step > high)
        if (now == meets).all():
            return step
        meets = now
        step = np.where(meets, np.clip(step, low, high), 0.0)
        step[~meets] = -np.linalg.solve(metric[np.ix_(~meets, ~meets)], metric[np.ix_(~meets, meets)] @ step[meets])
    return np.asarray(lsq_linear(np.linalg.cholesky(metric).T, np.zeros(len(low)), (low, high), method="bvls").x)
