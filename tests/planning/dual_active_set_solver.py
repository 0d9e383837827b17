"""Our own dual active-set solver, compiled (kernels/dual_active_set.py), for strictly convex programs without cones."""

from __future__ import annotations

import numpy as np

from planning.quadratic_program import INFEASIBLE, NUMERICAL, QPSolution, QuadraticProgram
from tests.kernels_called import called

NAME = "dual active set"


class DualActiveSetSolver:
    """One workspace, kept warm: rows and Hessian that are the same objects as at the last call aren't loaded again."""

    def __init__(self) -> None:
        from planning.kernels import allocation, loading, workspace

        self._solve, self._loading, self._workspaces = called(allocation.solve_program), loading, workspace
        self._last: QuadraticProgram | None = None

    def solve(self, program: QuadraticProgram) -> QPSolution:
        if program.cones or not self._load(program):
            return QPSolution.failed(program, NUMERICAL, NAME, f"{NAME}: not strictly convex, or has cones")
        status, claim = self._solve(self._floats, self._ints), self._workspace.claim
        if status == 0:
            return QPSolution.checked(program, claim.x.copy(), claim.y.copy(), (), NAME)
        if status == 1:
            return QPSolution.failed(program, INFEASIBLE, NAME, f"{NAME}: a Farkas ray proves it infeasible")
        return QPSolution.failed(program, NUMERICAL, NAME, f"{NAME}: no proven answer (status {status})")

    def _load(self, program: QuadraticProgram) -> bool:
        last, self._last = self._last, None
        if last is None or last.rows is not program.rows or last.hessian is not program.hessian:
            if not self._loading.is_strictly_convex(program.hessian):
                return False
            sizes = self._workspaces.Sizes(program.n, len(program.upper), program.n_equalities)
            self._floats, self._ints = sizes.allocate()
            self._workspace = self._workspaces.views(self._floats, self._ints)
            self._loading.load(self._workspace, program)
            self._loading.load_spans(self._workspace, self._workspace.problem.rows != 0)
        else:
            self._loading.load_limits(self._workspace, program)
            self._loading.load_gradient(self._workspace, program.gradient, program.constant)
        self._last = program
        return bool(np.isfinite(self._workspace.problem.free).all())
