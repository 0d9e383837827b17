"""A convex quadratic program as a value, a solution, and the proof of one by the other.

    minimise    ½ xᵀ H x + fᵀ x + constant
    such that   lower <= (x, R x) <= upper      the first n bound x; the last `n_equalities` are A x = b
                offset_k + M_k x in the second-order cone, s_0 >= ‖(s_1, s_2, …)‖, for each cone k

One signed multiplier y for each bound and row: positive pushes down from the upper limit, negative up from
the lower one. With a multiplier z_k in the (self-dual) cone for each cone, a solution has

    H x + f + (I, R)ᵀ y - sum_k M_kᵀ z_k = 0,     gap = sum |y| slack + sum z_kᵀ s_k = 0      (KKT)

and `gap` is the primal less the dual value. Effort, here as in the contract, is `sum w F²` without a ½, so
`H = 2 diag(w)`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np

from cartgrasp.frames import Array

OPTIMAL, INFEASIBLE, NUMERICAL = "optimal", "infeasible", "numerical"
EQUALITY_TOLERANCE = 1e-9
STATIONARITY_TOLERANCE = 1e-8


@dataclass(frozen=True, eq=False)
class Cone:
    """`offset + rows @ x` lies in the second-order cone; rows (k, n), offset (k,)."""

    name: str
    rows: Array
    offset: Array


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """See the module's head for the convention. H (n, n), f (n,), R (m, n), lower and upper (n + m,)."""

    hessian: Array
    gradient: Array
    rows: Array
    lower: Array
    upper: Array
    n_equalities: int
    lower_names: tuple[str, ...]
    upper_names: tuple[str, ...]
    cones: tuple[Cone, ...] = ()
    constant: float = 0.0

    @property
    def n(self) -> int:
        return len(self.gradient)

    @property
    def equality(self) -> tuple[Array, Array]:
        """A and b of A x = b."""
        start = len(self.rows) - self.n_equalities
        return self.rows[start:], self.upper[self.n + start :]

    @property
    def inequality(self) -> tuple[Array, Array, Array]:
        """C and its lower and upper limits."""
        stop = len(self.rows) - self.n_equalities
        return self.rows[:stop], self.lower[self.n : self.n + stop], self.upper[self.n : self.n + stop]

    @property
    def bounds(self) -> tuple[Array, Array]:
        return self.lower[: self.n], self.upper[: self.n]

    @cached_property
    def sense(self) -> Array:
        """True for the entries of (x, R x) that are equalities, shape (n + m,)."""
        sense = np.zeros(len(self.upper), dtype=bool)
        sense[len(sense) - self.n_equalities :] = True
        return sense

    def with_equality_value(self, value: Array) -> QuadraticProgram:
        """The same program with another b: the only thing that is new on the fast path."""
        lower, upper = self.lower.copy(), self.upper.copy()
        start = len(lower) - self.n_equalities
        lower[start:] = upper[start:] = value
        return replace(self, lower=lower, upper=upper)

    def cost(self, x: Array) -> float:
        return float(x @ (0.5 * (self.hessian @ x) + self.gradient)) + self.constant

    def active(self, solution: QPSolution) -> tuple[str, ...]:
        """Names of the limits that push back on a solution (multiplier above 1e-7 of the largest)."""
        y, names = solution.multipliers, []
        largest = max(1.0, float(np.abs(y).max(initial=0.0)))
        for index in np.flatnonzero(np.abs(y) > 1e-7 * largest):
            if index < len(y) - self.n_equalities:
                names.append(self.upper_names[index] if y[index] > 0 else self.lower_names[index])
        pairs = zip(self.cones, solution.cone_multipliers, strict=True)
        return (*names, *(cone.name for cone, z in pairs if z[0] > 1e-7 * largest))


@dataclass(frozen=True)
class Residuals:
    """Worst violation of A x = b, of limits and cones, of stationarity, and the duality gap over max(1,
    |cost|)."""

    equality: float
    limits: float
    stationarity: float
    gap: float

    def as_dict(self) -> dict[str, float]:
        return {part.name: getattr(self, part.name) for part in fields(self)}


@dataclass(frozen=True, eq=False)
class QPSolution:
    """`optimal` is verified; `infeasible` is what a solver says and stays unproven until a certificate
    verifies."""

    status: str
    x: Array
    multipliers: Array
    cone_multipliers: tuple[Array, ...]
    residuals: Residuals
    cost: float
    solver: str
    message: str = ""

    @classmethod
    def failed(cls, program: QuadraticProgram, status: str, solver: str, message: str) -> Self:
        nothing = Residuals(np.inf, np.inf, np.inf, np.inf)
        x, y = np.zeros(program.n), np.zeros(len(program.upper))
        return cls(
            status,
            x,
            y,
            tuple(np.zeros(len(c.offset)) for c in program.cones),
            nothing,
            np.inf,
            solver,
            message,
        )

    @classmethod
    def checked(
        cls, program: QuadraticProgram, x: Array, y: Array, z: Sequence[Array], solver: str, message: str = ""
    ) -> Self:
        """A candidate with its residuals; `optimal` only if these are within tolerance."""
        residuals, cost = verify(program, x, y, z), program.cost(x)
        status = OPTIMAL if is_proven(program, x, residuals) else NUMERICAL
        return cls(status, x, y, tuple(z), residuals, cost, solver, message)


def verify(program: QuadraticProgram, x: Array, y: Array, z: Sequence[Array] = ()) -> Residuals:
    """Residuals of the KKT conditions, by numpy alone. A multiplier of the wrong sign, against a limit that
    isn't there, counts as zero: it can't hide a gradient."""
    lower, upper, n = program.lower, program.upper, program.n
    values = np.concatenate((x, program.rows @ x))
    above, below = upper - values, values - lower
    y = np.where(np.where(y > 0, above, below) < np.inf, y, 0.0)
    gradient = program.hessian @ x + program.gradient + y[:n] + y[n:] @ program.rows
    held = y != 0
    gap = float(np.abs(y[held]) @ np.abs(np.where(y > 0, above, below)[held]))
    first = len(values) - program.n_equalities
    equality = float(np.abs(above[first:]).max(initial=0.0))
    limits = max(0.0, -float(above[:first].min(initial=0.0)), -float(below[:first].min(initial=0.0)))
    for cone, multiplier in zip(program.cones, z, strict=True):
        s = cone.offset + cone.rows @ x
        inside = into_cone(multiplier)
        gradient = gradient - inside @ cone.rows
        gap += abs(float(inside @ s))
        limits = max(limits, float(np.linalg.norm(s[1:]) - s[0]))
    scale = max(1.0, abs(program.cost(x)))
    return Residuals(equality, limits, float(np.abs(gradient).max(initial=0.0)), gap / scale)


def is_proven(program: QuadraticProgram, x: Array, residuals: Residuals) -> bool:
    """Whether residuals are within tolerance, absolute up to wrenches of 1 N and relative above."""
    first = len(program.upper) - program.n_equalities
    scale = max(1.0, float(np.abs(program.upper[first:]).max(initial=0.0)))
    slope = max(1.0, float(np.abs(program.hessian @ x + program.gradient).max(initial=0.0)))
    return (
        residuals.equality <= EQUALITY_TOLERANCE * scale
        and residuals.limits <= EQUALITY_TOLERANCE * scale
        and residuals.stationarity <= STATIONARITY_TOLERANCE * slope
        and residuals.gap <= STATIONARITY_TOLERANCE
    )


def into_cone(multiplier: Array) -> Array:
    """The multiplier with its axis raised to lie in the second-order cone."""
    inside = multiplier.copy()
    inside[0] = max(multiplier[0], float(np.linalg.norm(multiplier[1:])))
    return inside
