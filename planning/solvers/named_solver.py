"""Any solver that is installed, by its name: programs through qpsolvers, those with second-order cones through cvxpy.

What a solver says is a proposal: of `infeasible` and `failed` qpsolvers makes one, and some solvers say either of
problems that have an answer. Whoever calls proves what is found, and asks elsewhere where nothing is.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import qpsolvers
from qpsolvers.exceptions import QPError
from scipy import sparse

from cartgrasp.errors import UsageError
from planning.quadratic_program import NUMERICAL, QPSolution, QuadraticProgram

from .one_sided import OneSided

MAX_MAGNITUDE = 1e50  # what is larger overflows in a proof
QPSOLVERS_SETTINGS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12},
    "daqp": {"primal_tol": 1e-10},
    "highs": {
        "primal_feasibility_tolerance": 1e-9,
        "dual_feasibility_tolerance": 1e-9,
        "qp_iteration_limit": 2000,  # where the cost is flat it cycles, and ends by itself never
        "time_limit": 1.0,
    },
    "osqp": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20_000},
    "piqp": {"eps_abs": 1e-12, "eps_rel": 1e-12},
    "proxqp": {"eps_abs": 1e-10, "eps_rel": 0.0},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20_000},
}
"""Nearer than they come by themselves: a polish needs the active limits."""
SOLVER_ERRORS = (QPError, ValueError, RuntimeError, ArithmeticError)
"""What solvers raise where they fail."""


def check_installed(name: str) -> str:
    """The name of a solver that is installed, in the letters that qpsolvers has it."""
    found, small = sorted(qpsolvers.available_solvers), str(name).lower()
    if small not in found:
        raise UsageError(f"solver: {name!r} is unknown or not installed; there are {', '.join(found)}")
    return small


class NamedSolver:
    """Proposes answers, whose status is `optimal` where they verify as they are."""

    def __init__(self, name: str) -> None:
        self.name = check_installed(name)

    def solve(self, program: QuadraticProgram) -> QPSolution:
        if not program.cones:
            return self._quadratic(program)
        from .cvxpy_problem import solve, takes_cones

        if takes_cones(self.name):
            return solve(program, self.name)
        return QPSolution.failed(program, NUMERICAL, self.name, f"{self.name} takes no second-order cones")

    def _quadratic(self, program: QuadraticProgram) -> QPSolution:
        sides = OneSided.of(program)
        as_asked = sparse.csc_matrix if self.name in qpsolvers.sparse_solvers else np.asarray
        G, h = (as_asked(sides.G), sides.h) if len(sides.h) else (None, None)
        A, b = (as_asked(sides.A), sides.b) if len(sides.b) else (None, None)
        problem = qpsolvers.Problem(as_asked(program.hessian), program.gradient.copy(), G, h, A, b)
        try:
            with warnings.catch_warnings():  # they say on stderr what the status says
                warnings.simplefilter("ignore")
                found = qpsolvers.solve_problem(problem, solver=self.name, **QPSOLVERS_SETTINGS.get(self.name, {}))
        except SOLVER_ERRORS as error:
            return QPSolution.failed(program, NUMERICAL, self.name, f"{self.name} refused the problem ({error})")
        sizes = program.n, len(sides.b), len(sides.h)
        parts = [found.x, found.y if len(sides.b) else (), found.z if len(sides.h) else ()]
        if not all(_is_answer(part, size) for part, size in zip(parts, sizes, strict=True)):
            return QPSolution.failed(program, NUMERICAL, self.name, f"{self.name} found no answer")
        x, of_equal, of_rest = (np.asarray(part, dtype=float) for part in parts)
        y = sides.multipliers(of_equal, of_rest, len(program.upper))
        return QPSolution.checked(program, x, y, (), self.name)


def _is_answer(part: Any, size: int) -> bool:
    """Whether it is that many numbers, none of which would overflow in a proof."""
    return part is not None and np.shape(part) == (size,) and bool(np.abs(part).max(initial=0.0) <= MAX_MAGNITUDE)
