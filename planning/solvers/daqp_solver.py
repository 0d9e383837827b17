"""daqp, a dual active-set solver (Arnström, Bemporad, Axehill 2022), kept warm between calls."""

from __future__ import annotations

import daqp
import numpy as np

from planning.quadratic_program import INFEASIBLE, NUMERICAL, QPSolution, QuadraticProgram

EQUALITY_SENSE = 5
INFEASIBLE_FLAG = -1
OVERDETERMINED_FLAG = -6
DAQP_SETTINGS = {"primal_tol": 1e-10}


class DaqpSolver:
    """One daqp workspace. Arrays that are the same objects as at the last call are not handed over again."""

    def __init__(self) -> None:
        self._model = daqp.Model()
        self._last: QuadraticProgram | None = None

    def solve(self, program: QuadraticProgram) -> QPSolution:
        flag = self._load(program)
        if flag < 0:
            self._last = None
            status = INFEASIBLE if flag in (INFEASIBLE_FLAG, OVERDETERMINED_FLAG) else NUMERICAL
            return QPSolution.failed(program, status, "daqp", f"daqp refused the problem (flag {flag})")
        x, _, flag, info = self._model.solve()
        if flag > 0:
            return QPSolution.checked(program, x, info["lam"], (), "daqp")
        self._last = None  # a workspace is not trusted after a failure
        status = INFEASIBLE if flag == INFEASIBLE_FLAG else NUMERICAL
        return QPSolution.failed(program, status, "daqp", f"daqp gave up (flag {flag})")

    def _load(self, program: QuadraticProgram) -> int:
        last, self._last = self._last, program
        if last is None or last.rows.shape != program.rows.shape or last.n_equalities != program.n_equalities:
            self._model = daqp.Model()
            self._model.settings = DAQP_SETTINGS
            sense = np.where(program.sense, EQUALITY_SENSE, 0).astype(np.int32)
            matrices = (program.hessian, program.gradient, program.rows)
            return int(self._model.setup(*matrices, program.upper, program.lower, sense)[0])
        return int(
            self._model.update(
                H=None if program.hessian is last.hessian else program.hessian,
                f=None if program.gradient is last.gradient else program.gradient,
                A=None if program.rows is last.rows else program.rows,
                bupper=program.upper,
                blower=program.lower,
            )
        )
