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

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from cartgrasp.frames import Array

OPTIMAL, INFEASIBLE, NUMERICAL = "optimal", "infeasible", "numerical"
EQUALITY_TOLERANCE = 1e-9
STATIONARITY_TOLERANCE = 1e-8
LimitNames = tuple[tuple[str, ...], tuple[str, ...]]
"""The names of the lower limits, and those of the upper limits."""


@dataclass(frozen=True, eq=False)
class Cone:
    """`offset + rows @ x` lies in the second-order cone; rows (k, n), offset (k,). Where they stand among the program's
    rows too, without limits there, `row` is the first of these."""

    name: str
    rows: Array
    offset: Array
    row: int | None = None

    def own(self, of_rows: Array) -> Array:
        """The part for this cone (k, ...) of values of the program's rows (m, ...); zero if it has none there."""
        k = len(self.offset)
        return np.zeros((k, *of_rows.shape[1:])) if self.row is None else of_rows[self.row : self.row + k]


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """See the module's head for the convention. H (n, n), f (n,), R (m, n), lower and upper (n + m,). What has an
    empty name is no limit, but part of how the cost is written."""

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

    @cached_property
    def stacked(self) -> Array:
        """H, I and R above each other: one product gives all that a proof needs of x."""
        return np.concatenate((self.hessian, np.eye(self.n), self.rows))

    def with_equality_value(self, value: Array) -> Self:
        """The same program with another b: the only thing that is new on the fast path."""
        lower, upper = self.lower.copy(), self.upper.copy()
        start = len(lower) - self.n_equalities
        lower[start:] = upper[start:] = value
        return self._but(lower=lower, upper=upper)

    def with_last_rows(self, matrix: Array, low: Array, high: Array) -> Self:
        """The same program with the last rows of R and their limits replaced, all that contacts change."""
        start = len(self.lower) - len(matrix)
        lower, upper, stacked = self.lower.copy(), self.upper.copy(), self.stacked.copy()
        lower[start:], upper[start:], stacked[self.n + start :] = low, high, matrix
        return self._but(lower=lower, upper=upper, stacked=stacked, rows=stacked[2 * self.n :])

    def with_cones(self, cones: tuple[Cone, ...]) -> Self:
        return self._but(cones=cones)

    def with_bounds(self, low: Array, high: Array, names: LimitNames) -> Self:
        """The same program with other bounds (k,) on its first unknowns."""
        k, lower, upper = len(low), self.lower.copy(), self.upper.copy()
        lower[:k], upper[:k] = low, high
        lower_names, upper_names = names[0] + self.lower_names[k:], names[1] + self.upper_names[k:]
        return self._but(lower=lower, upper=upper, lower_names=lower_names, upper_names=upper_names)

    def with_gradient(self, gradient: Array, constant: float) -> Self:
        return self._but(gradient=gradient, constant=constant)

    def _but(self, **changes: Any) -> Self:
        """A copy with fields replaced, as `dataclasses.replace` makes it, that keeps cached values: no change made here
        invalidates them."""
        program = object.__new__(type(self))
        program.__dict__.update(self.__dict__, **changes)
        return program

    def active(self, solution: QPSolution) -> tuple[str, ...]:
        """Names of the limits that push back on a solution (multiplier above 1e-7 of the largest)."""
        stop, least = len(self.lower) - self.n_equalities, _least_active(solution.multipliers)
        names = active_limits(solution.multipliers, (self.lower_names[:stop], self.upper_names[:stop]))
        cones = zip(self.cones, solution.cone_multipliers, strict=True)
        return (*names, *(cone.name for cone, z in cones if z[0] > least))

    def margins(self, x: Array) -> dict[str, float]:
        """How far x is from each limit, by name, in the limit's unit; of a cone `s_0 - ‖(s_1, s_2, …)‖`. Where limits
        have one name, the least."""
        stop = len(self.lower) - self.n_equalities
        values = np.concatenate([x, self.rows @ x])[:stop]
        rooms = (self.lower_names, values - self.lower[:stop]), (self.upper_names, self.upper[:stop] - values)
        told = [(n[i], float(room[i])) for n, room in rooms for i in np.flatnonzero(np.isfinite(room)) if n[i]]
        for cone in self.cones:
            s = cone.offset + cone.rows @ x
            told.append((cone.name, float(s[0] - np.linalg.norm(s[1:]))))
        found: dict[str, float] = {}
        for name, room in told:
            found[name] = min(room, found.get(name, math.inf))
        return found


class Residuals(NamedTuple):
    """Worst violation of A x = b, of limits and cones, of stationarity, and the duality gap over
    max(1, |cost|); and what they are measured by: the cost, the largest |b| and the largest slope of the
    cost, each at least 1."""

    equality: float
    limits: float
    stationarity: float
    gap: float
    cost: float = np.inf
    wrench_scale: float = 1.0
    slope_scale: float = 1.0

    @property
    def feasible(self) -> bool:
        """Whether the equality and the limits hold: absolute up to wrenches of 1 N, relative above."""
        tolerance = EQUALITY_TOLERANCE * self.wrench_scale
        return self.equality <= tolerance and self.limits <= tolerance

    @property
    def proven(self) -> bool:
        """Whether all are within tolerance."""
        return (
            self.feasible
            and self.stationarity <= STATIONARITY_TOLERANCE * self.slope_scale
            and self.gap <= STATIONARITY_TOLERANCE
        )

    def as_dict(self) -> dict[str, float]:
        return {name: getattr(self, name) for name in ("equality", "limits", "stationarity", "gap")}


NO_RESIDUALS = Residuals(np.inf, np.inf, np.inf, np.inf)
"""Residuals where there is no answer."""


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
        x, y = np.zeros(program.n), np.zeros(len(program.upper))
        z = tuple(np.zeros(len(cone.offset)) for cone in program.cones)
        return cls(status, x, y, z, NO_RESIDUALS, np.inf, solver, message)

    @classmethod
    def checked(
        cls, program: QuadraticProgram, x: Array, y: Array, z: Sequence[Array], solver: str, message: str = ""
    ) -> Self:
        """A candidate with its residuals; `optimal` only if these are within tolerance."""
        residuals = verify(program, x, y, z)
        status = OPTIMAL if residuals.proven else NUMERICAL
        return cls(status, x, y, tuple(z), residuals, residuals.cost, solver, message)


def verify(program: QuadraticProgram, x: Array, y: Array, z: Sequence[Array] = ()) -> Residuals:
    """Residuals of the KKT conditions, by numpy alone. A multiplier of the wrong sign, against a limit that
    isn't there, counts as zero: it can't hide a gradient."""
    n, first = program.n, len(y) - program.n_equalities
    image = program.stacked.dot(x)
    curved, values = image[:n], image[n:]
    cost = float(x.dot(0.5 * curved + program.gradient)) + program.constant
    gradient = curved + program.gradient
    slope = max(1.0, highest(np.abs(gradient)))
    above, below = program.upper - values, values - program.lower
    limits = max(0.0, -lowest(above[:first]), -lowest(below[:first]))
    gap, held = 0.0, y.nonzero()[0]
    for i, dual in zip(held.tolist(), y[held].tolist(), strict=True):
        slack = above.item(i) if dual > 0 else below.item(i)
        if slack == np.inf:
            y = y.copy()
            y[i] = 0.0
        else:
            gap += abs(dual * slack)
    if not math.isfinite(gap):  # a solver's multipliers may not be
        return NO_RESIDUALS
    gradient += y.dot(program.stacked[n:])
    for cone, multiplier in zip(program.cones, z, strict=True):
        s, inside = cone.offset + cone.rows @ x, into_cone(multiplier)
        gradient -= inside @ cone.rows
        gap += abs(float(inside @ s))
        limits = max(limits, float(np.linalg.norm(s[1:]) - s[0]))
    missed, asked = above[first:].tolist(), program.upper[first:].tolist()
    return Residuals(
        equality=max(map(abs, missed), default=0.0),
        limits=limits,
        stationarity=highest(np.abs(gradient)),
        gap=gap / max(1.0, abs(cost)),
        cost=cost,
        wrench_scale=max((1.0, *map(abs, asked))),
        slope_scale=slope,
    )


def highest(values: Array) -> float:
    """The largest of `values`, or NaN where there is one: as `values.max()`, in a fifth of its time on short rows."""
    return float(values[values.argmax()])


def lowest(values: Array) -> float:
    return float(values[values.argmin()])


def into_cone(multiplier: Array) -> Array:
    """The multiplier with its axis raised to lie in the second-order cone."""
    inside = multiplier.copy()
    inside[0] = max(multiplier[0], float(np.linalg.norm(multiplier[1:])))
    return inside


def active_limits(multipliers: Array, names: LimitNames) -> tuple[str, ...]:
    """The names of the lower and upper limits that are active: with multipliers above 1e-7 of the largest. The limits'
    multipliers come first."""
    lower, upper = names
    least, found = _least_active(multipliers), []
    for i in multipliers[: len(lower)].nonzero()[0].tolist():
        if abs(multipliers[i]) > least:
            found.append(upper[i] if multipliers[i] > 0 else lower[i])
    return tuple(name for name in found if name)


def _least_active(multipliers: Array) -> float:
    return 1e-7 * max(1.0, float(np.abs(multipliers).max(initial=0.0)))
