"""What stays the same from tick to tick: arms, limits, objective and the cart's effective rows.

With S the basis of the free velocities, k = n_free, and G_i the grasp map of arm i at its contact, the
equality is `Sᵀ sum_i G_i F_i = Sᵀ wrench_b` (physics 8): k rows of full rank, free of the cart's parameters.

A contact enters only the rows with a moment, and linearly. So where contacts may vary over a convex set with
vertices v, the wrenches within reach are the union over pairs of vertices (high, low) of

    m(high) F >= tau,    m(low) F <= tau,    the other rows as equalities,

because m(.) F takes every value between its largest and its smallest: a `range` program, linear and convex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.contacts import grasp_map_planar
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .limits import LimitRows, limits_of
from .objectives import Cost, Objective, WeightedWrench
from .quadratic_program import Cone, QuadraticProgram

if TYPE_CHECKING:
    from cartgrasp.model import CartModel

PLANAR_NAMES = ("fx", "fy", "tau")


@dataclass(frozen=True, eq=False)
class AllocationTemplate:
    """n arms, their limits side by side over F (6n,), and an objective; basis_b is S, shape (3, k)."""

    arms: tuple[Arm, ...]
    basis_b: Array
    limits: LimitRows
    objective: Objective

    @classmethod
    def of(cls, cart: CartModel, arms: Sequence[Arm], objective: Objective | None = None) -> Self:
        arms = tuple(arms)
        names = [arm.name for arm in arms]
        if not arms:
            raise UsageError("arms: none given; at least one arm is needed")
        for name in names:
            if names.count(name) > 1:
                raise UsageError(f"arms: {name} stands twice; names must differ")
        basis_b = cart.constraints.basis_b
        if np.any(basis_b[2, :-1]):
            raise UsageError("constraints: only the last free velocity may turn the cart; choose another basis")
        return cls(arms, basis_b, _side_by_side(arms), objective or WeightedWrench())

    # --- structure ----------------------------------------------------------------------------------------

    @property
    def n(self) -> int:
        """Number of wrench components, 6 per arm."""
        return 6 * len(self.arms)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(arm.name for arm in self.arms)

    @cached_property
    def yaws(self) -> Array:
        return np.array([arm.yaw for arm in self.arms])

    @cached_property
    def effort_weights(self) -> Array:
        return np.concatenate([arm.weights for arm in self.arms])

    @cached_property
    def moment_row(self) -> int | None:
        """The effective row that depends on the contacts, which is the last; None on a rail."""
        return self.basis_b.shape[1] - 1 if self.basis_b[2].any() else None

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """Effective rows in words: `fx`, `tau`, `tau - 0.3 fy`."""
        return tuple(in_words(column) for column in self.basis_b.T)

    @cached_property
    def hessian(self) -> Array:
        cost = self.cost(np.zeros(self.n))
        hessian = np.diag(2.0 * cost.weights)
        return hessian if cost.coupling is None else hessian + 2.0 * cost.coupling

    def cost(self, previous: Array) -> Cost:
        return self.objective.cost(self.arms, previous)

    def effort(self, wrenches: Array) -> float:
        """`sum weight component²` by the arms' own weights, whatever the objective."""
        return float(wrenches.dot(self.effort_weights * wrenches))

    # --- programs -----------------------------------------------------------------------------------------

    def contact_rows(self, points: Array, yaws: Array | None = None) -> Array:
        """`Sᵀ G` of contact points (..., 3), shape (..., k, 6); yaws are the arms' where points are (..., n,
        3)."""
        grasp_map = grasp_map_planar(points, self.yaws if yaws is None else yaws)
        return np.asarray(self.basis_b.T @ grasp_map)

    def program(self, rows: Array, target: Array, cost: Cost) -> QuadraticProgram:
        """One contact an arm: `rows` (n, k, 6) from `contact_rows`, `target` = Sᵀ wrench_b (k,)."""
        matrix = rows.transpose(1, 0, 2).reshape(len(target), self.n)
        return self._filled(self._at_points, matrix, (target, target), cost)

    def range_program(self, rows: tuple[Array, Array], target: Array, cost: Cost) -> QuadraticProgram:
        """Contacts between two vertices: `rows` at the high and the low one. Rows: high, low, then the
        equalities."""
        moment = self.moment_row
        high, low = (part.transpose(1, 0, 2).reshape(len(target), self.n) for part in rows)
        others = [i for i in range(len(target)) if i != moment]
        matrix = np.concatenate([high[moment, None], low[moment, None], high[others]])
        below = np.concatenate([[target[moment], -np.inf], target[others]])
        above = np.concatenate([[np.inf, target[moment]], target[others]])
        return self._filled(self._over_ranges, matrix, (below, above), cost)

    def slack_map(self, is_range: bool) -> Array:
        """T, (effective rows of the program, k): where a slack of each effective row of `target` enters."""
        identity = np.eye(self.basis_b.shape[1])
        if not is_range:
            return identity
        moment = self.moment_row
        others = [i for i in range(len(identity)) if i != moment]
        return np.vstack([identity[moment], identity[moment], identity[others]])

    @cached_property
    def _at_points(self) -> QuadraticProgram:
        return self._blank(self.basis_b.shape[1], self.basis_b.shape[1])

    @cached_property
    def _over_ranges(self) -> QuadraticProgram:
        return self._blank(self.basis_b.shape[1] + 1, self.basis_b.shape[1] - 1)

    def _blank(self, n_effective: int, n_equalities: int) -> QuadraticProgram:
        """A program but for its effective rows, which come last."""
        limits, effective = self.limits, ("effective row",) * n_effective
        zero = np.zeros(n_effective)
        return QuadraticProgram(
            hessian=self.hessian,
            gradient=np.zeros(self.n),
            rows=np.concatenate([limits.rows, np.zeros((n_effective, self.n))]),
            lower=np.concatenate([limits.lower, np.full(len(limits.limits), -np.inf), zero]),
            upper=np.concatenate([limits.upper, limits.limits, zero]),
            n_equalities=n_equalities,
            lower_names=limits.lower_names + limits.names + effective,
            upper_names=limits.upper_names + limits.names + effective,
            cones=limits.cones,
        )

    def _filled(
        self, blank: QuadraticProgram, matrix: Array, values: tuple[Array, Array], cost: Cost
    ) -> QuadraticProgram:
        return blank.with_last_rows(matrix, *values).with_gradient(cost.gradient, cost.constant)


def in_words(direction: Array) -> str:
    """A combination of (fx, fy, tau), as `fx` or `tau - 0.3 fy`."""
    parts = sorted(zip(direction, PLANAR_NAMES, strict=True), key=lambda part: part[1] != "tau" or part[0] < 0)
    text = ""
    for factor, name in parts:
        if abs(factor) > 1e-9:
            sign = (" - " if factor < 0 else " + ") if text else ("-" if factor < 0 else "")
            text += sign + ("" if abs(abs(factor) - 1) < 1e-9 else f"{abs(factor):.4g} ") + name
    return text or "0"


def _side_by_side(arms: Sequence[Arm]) -> LimitRows:
    """Limits over all arms' wrenches, with the arm's name before each name."""
    each = [limits_of(arm) for arm in arms]
    n, k = 6 * len(arms), sum(len(part.rows) for part in each)
    rows, cones, start = np.zeros((k, n)), [], 0
    for i, (arm, part) in enumerate(zip(arms, each, strict=True)):
        columns = slice(6 * i, 6 * i + 6)
        rows[start : start + len(part.rows), columns] = part.rows
        start += len(part.rows)
        for cone in part.cones:
            wide = np.zeros((len(cone.offset), n))
            wide[:, columns] = cone.rows
            cones.append(Cone(f"{arm.name}: {cone.name}", wide, cone.offset))

    def named(field: str) -> tuple[str, ...]:
        pairs = zip(arms, each, strict=True)
        return tuple(f"{arm.name}: {name}" for arm, part in pairs for name in getattr(part, field))

    return replace(
        each[0],
        lower=np.concatenate([part.lower for part in each]),
        upper=np.concatenate([part.upper for part in each]),
        lower_names=named("lower_names"),
        upper_names=named("upper_names"),
        rows=rows,
        limits=np.concatenate([part.limits for part in each]),
        names=named("names"),
        cones=tuple(cones),
    )
