"""A program in cvxpy: to read and to change, and the road to solvers of second-order cones."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cvxpy
import numpy as np
from cvxpy.reductions.solvers.defines import INSTALLED_CONIC_SOLVERS, SOLVER_MAP_CONIC

from cartgrasp.frames import Array
from planning.quadratic_program import NUMERICAL, QPSolution, QuadraticProgram

from .one_sided import Places

CVXPY_SETTINGS: dict[str, dict[str, Any]] = {
    "CLARABEL": {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10},
    "ECOS": {"abstol": 1e-10, "reltol": 1e-10, "feastol": 1e-10},
    "SCS": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20_000},
}
"""Nearer than they come by themselves: a polish needs the active limits."""


Unknown = tuple[str, slice, Any]
"""A name, where it stands in x, and the variable."""
Side = tuple[Any, Places, float]
"""A constraint, what it holds of the entries of (x, R x), and the sign of its multipliers in y."""


@dataclass(frozen=True, eq=False)
class Posed:
    """A cvxpy problem over the unknowns x, with its constraints: of bounds and rows, and of cones in their order."""

    problem: Any
    x: Any
    sides: tuple[Side, ...]
    cones: tuple[Any, ...]


def pose(program: QuadraticProgram, arms: Sequence[str] = (), target: Any = None) -> Posed:
    """A variable (6,) for each arm, by its name, and `own` for the unknowns behind them. Constraints are labelled by
    whose they are. `target` is an expression for what the equalities are held to, in the place of their numbers."""
    unknowns = _unknowns(program, arms)
    bounded = [(f"{name}:", np.arange(program.n)[where], variable) for name, where, variable in unknowns]
    first, stop = program.n, len(program.lower) - program.n_equalities
    names = zip(program.lower_names[first:stop], program.upper_names[first:stop], strict=True)
    owners = np.array([_owner(low or high, arms) for low, high in names])
    groups = [(str(owner), first + np.flatnonzero(owners == owner)) for owner in dict.fromkeys(owners.tolist())]
    rowed = [(f"{owner}, rows:", rows, _over(program.rows[rows - first], unknowns)) for owner, rows in groups]
    sides = [side for owner, rows, values in bounded + rowed for side in _held(program, (owner, rows, values))]
    asked = np.flatnonzero(program.sense)
    if len(asked):
        values = _over(program.rows[asked - first], unknowns)
        held = values == (program.upper[asked] if target is None else target)
        sides.append((held.set_label("what is asked of the cart"), asked, 1.0))
    pairs = [(cone, cone.offset + _over(cone.rows, unknowns)) for cone in program.cones]
    cones = [cvxpy.SOC(s[0], s[1:]).set_label(cone.name) for cone, s in pairs]
    constraints = [*(side[0] for side in sides), *cones]
    problem = cvxpy.Problem(cvxpy.Minimize(_cost(program, unknowns)), constraints)
    return Posed(problem, cvxpy.hstack([variable for _, _, variable in unknowns]), tuple(sides), tuple(cones))


def takes_cones(name: str) -> bool:
    """Whether cvxpy has a solver of second-order cones of this name."""
    known = name.upper() in INSTALLED_CONIC_SOLVERS
    return known and cvxpy.SOC in SOLVER_MAP_CONIC[name.upper()].SUPPORTED_CONSTRAINTS


def solve(program: QuadraticProgram, name: str) -> QPSolution:
    """A proposal of cvxpy's solver of this name."""
    posed, n = pose(program), len(program.upper)
    try:
        with warnings.catch_warnings():  # of what is inaccurate, which the proof tells
            warnings.simplefilter("ignore")
            posed.problem.solve(solver=name.upper(), **CVXPY_SETTINGS.get(name.upper(), {}))
    except (cvxpy.error.SolverError, ValueError, ArithmeticError) as error:
        return QPSolution.failed(program, NUMERICAL, name, f"{name} refused the problem ({error})")
    if posed.problem.status not in (cvxpy.OPTIMAL, cvxpy.OPTIMAL_INACCURATE):
        return QPSolution.failed(program, NUMERICAL, name, f"{name} found no answer")
    y, x = np.zeros(n), np.asarray(posed.x.value, dtype=float)
    for constraint, rows, sign in posed.sides:
        y[rows] += sign * np.asarray(constraint.dual_value)
    z = [np.concatenate([np.ravel(part) for part in cone.dual_value]) for cone in posed.cones]
    return QPSolution.checked(program, x, y, z, name)


def _unknowns(program: QuadraticProgram, arms: Sequence[str]) -> list[Unknown]:
    found = [(arm, slice(6 * i, 6 * i + 6), cvxpy.Variable(6, name=arm)) for i, arm in enumerate(arms)]
    if left := program.n - 6 * len(arms):
        name = "own" if arms else "x"
        found.append((name, slice(6 * len(arms), program.n), cvxpy.Variable(left, name=name)))
    return found


def _over(matrix: Array, unknowns: Sequence[Unknown]) -> Any:
    """matrix @ x, over the unknowns that enter."""
    parts = [matrix[:, where] @ variable for _, where, variable in unknowns if matrix[:, where].any()]
    return sum(parts[1:], parts[0]) if parts else cvxpy.Constant(np.zeros(len(matrix)))


def _held(program: QuadraticProgram, what: tuple[str, Places, Any]) -> list[Side]:
    """The constraints of some entries of (x, R x), which have these values."""
    (owner, rows, values), found = what, []
    lower, upper = program.lower[rows], program.upper[rows]
    equal, free = lower == upper, np.logical_not(program.sense[rows])
    for kind, which, sign in (
        ("held", free & equal, 1.0),
        ("at most", free & ~equal & (upper < np.inf), 1.0),
        ("at least", free & ~equal & (lower > -np.inf), -1.0),
    ):
        if which.any():
            value = values if which.all() else values[np.flatnonzero(which)]
            limit = (lower if kind == "at least" else upper)[which]
            held = value == limit if kind == "held" else value <= limit if sign > 0 else value >= limit
            found.append((held.set_label(f"{owner} {kind}"), rows[which], sign))
    return found


def _cost(program: QuadraticProgram, unknowns: Sequence[Unknown]) -> Any:
    """The cost in cvxpy: a sum of squares where no unknowns are coupled."""
    hessian, diagonal = program.hessian, np.diagonal(program.hessian)
    if np.count_nonzero(hessian) == np.count_nonzero(diagonal):
        squares = [0.5 * diagonal[where] @ cvxpy.square(variable) for _, where, variable in unknowns]
        cost = sum(squares[1:], squares[0])
    else:
        x = cvxpy.hstack([variable for _, _, variable in unknowns])
        cost = 0.5 * cvxpy.quad_form(x, cvxpy.psd_wrap(hessian))
    if program.gradient.any():
        cost = cost + _over(program.gradient[None], unknowns)[0]
    return cost + program.constant if program.constant else cost


def _owner(name: str, arms: Sequence[str]) -> str:
    """An arm, the cart, or the objective, whose rows have no names."""
    found = name.partition(":")[0]
    return found if found in arms else "cart" if name else "objective"
