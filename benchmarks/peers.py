"""Other solvers on the planner's own programs. Each peer is made for a first program, keeps its workspace, and is then
called with another of the same structure; what a solver wants in its own form is made before the clock runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from cartgrasp.frames import Array
from planning.quadratic_program import QuadraticProgram

# Through qpsolvers as when called directly.
TIGHT: dict[str, dict[str, Any]] = {
    "piqp": {"eps_abs": 1e-9, "eps_rel": 1e-9},
    "proxqp": {"eps_abs": 1e-9},
    "osqp": {"eps_abs": 1e-6, "eps_rel": 1e-6, "max_iter": 20000},
}
Solve = Callable[[int], Array]
Build = Callable[[Sequence[QuadraticProgram], bool], Solve]


@dataclass(frozen=True)
class Peer:
    """`build(programs, fixed)` gives a function from the index of a program to x; `fixed`: only b differs."""

    name: str
    module: str
    build: Build

    @property
    def installed(self) -> bool:
        return find_spec(self.module) is not None


@dataclass(frozen=True, eq=False)
class Blocks:
    """A program as G x <= h, A x = b, lb <= x <= ub: the form most peers ask for."""

    P: Array
    q: Array
    G: Array
    h: Array
    A: Array
    b: Array
    lb: Array
    ub: Array

    @classmethod
    def of(cls, program: QuadraticProgram) -> Blocks:
        (A, b), (G, _, h), (lb, ub) = program.equality, program.inequality, program.bounds
        return cls(program.hessian, program.gradient, G.copy(), h.copy(), A.copy(), b.copy(), lb, ub)

    @property
    def one_sided(self) -> tuple[Array, Array]:
        """All inequalities as rows G x <= h, without those that are infinite."""
        eye = np.eye(len(self.q))
        up, low = np.isfinite(self.ub), np.isfinite(self.lb)
        return np.vstack([self.G, eye[up], -eye[low]]), np.concatenate([self.h, self.ub[up], -self.lb[low]])


def most(program: QuadraticProgram) -> float:
    """The largest t such that A x = t b can be kept, by HiGHS."""
    block = Blocks.of(program)
    A = np.column_stack([block.A, -block.b])
    G = np.column_stack([block.G, np.zeros(len(block.h))])
    bounds = [*zip(block.lb, block.ub, strict=True), (0.0, None)]
    cost = np.append(np.zeros(len(block.q)), -1.0)
    found: Any = linprog(cost, G, block.h, A, np.zeros(len(block.b)), bounds=bounds)
    return float(found.x[-1])


def bare_daqp(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    import daqp

    first, model = programs[0], daqp.Model()
    model.settings = {"primal_tol": 1e-10}
    sense = np.where(first.sense, 5, 0).astype(np.int32)
    model.setup(first.hessian, first.gradient, first.rows, first.upper, first.lower, sense)

    def solve(k: int) -> Array:
        program = programs[k]
        model.update(H=None, f=None, A=None if fixed else program.rows, bupper=program.upper, blower=program.lower)
        return np.asarray(model.solve()[0])

    return solve


def with_quadprog(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    import quadprog

    problems = []
    for block in map(Blocks.of, programs):
        G, h = block.one_sided
        rows, values = np.vstack([block.A, -G]), np.concatenate([block.b, -h])
        problems.append((block.P, -block.q, np.ascontiguousarray(rows.T), values, len(block.b)))
    return lambda k: quadprog.solve_qp(*problems[k])[0]


def with_piqp(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    import piqp

    blocks = [Blocks.of(program) for program in programs]
    first, solver = blocks[0], piqp.DenseSolver()
    solver.settings.eps_abs, solver.settings.eps_rel = 1e-9, 1e-9
    solver.setup(first.P, first.q, first.A, first.b, first.G, None, first.h, first.lb, first.ub)
    return _updating(solver, blocks, fixed, lambda: solver.result.x)


def _updating(solver: Any, blocks: Sequence[Blocks], fixed: bool, answer: Callable[[], Array]) -> Solve:
    """Hands over what is new, and solves."""

    def solve(k: int) -> Array:
        if fixed:
            solver.update(b=blocks[k].b)
        else:
            solver.update(A=blocks[k].A, b=blocks[k].b)
        solver.solve()
        return np.array(answer())

    return solve


def with_proxqp(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    from proxsuite import proxqp

    blocks = [Blocks.of(program) for program in programs]
    first = blocks[0]
    solver = proxqp.dense.QP(len(first.q), len(first.b), len(first.h), True)
    solver.settings.eps_abs = 1e-9
    below = np.full(len(first.h), -1e20)
    big = 1e20
    solver.init(
        first.P,
        first.q,
        first.A,
        first.b,
        first.G,
        below,
        first.h,
        np.maximum(first.lb, -big),
        np.minimum(first.ub, big),
    )
    return _updating(solver, blocks, fixed, lambda: solver.results.x)


def with_osqp(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    import osqp

    first = programs[0]
    pattern = np.vstack([np.eye(first.n), np.where(_ever(programs), 1.0, 0.0)]).T.astype(bool)

    def values(program: QuadraticProgram) -> Array:
        return np.asarray(np.vstack([np.eye(program.n), program.rows]).T[pattern])

    matrix = sparse.csc_matrix(pattern.T.astype(float))
    matrix.data[:] = values(first)
    data = [values(program) for program in programs]
    solver = osqp.OSQP()
    tolerances = {"eps_abs": 1e-6, "eps_rel": 1e-6, "max_iter": 20000}
    hessian = sparse.csc_matrix(first.hessian)
    solver.setup(hessian, first.gradient.copy(), matrix, first.lower, first.upper, verbose=False, **tolerances)

    def solve(k: int) -> Array:
        program = programs[k]
        if fixed:
            solver.update(l=program.lower, u=program.upper)
        else:
            solver.update(l=program.lower, u=program.upper, Ax=data[k])
        return np.array(solver.solve(raise_error=False).x)

    return solve


def with_clarabel(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    import clarabel

    problems = []
    for block in map(Blocks.of, programs):
        G, h = block.one_sided
        matrix = sparse.csc_matrix(np.vstack([block.A, G]))
        cones = [clarabel.ZeroConeT(len(block.b)), clarabel.NonnegativeConeT(len(h))]
        problems.append((sparse.csc_matrix(np.triu(block.P)), block.q, matrix, np.concatenate([block.b, h]), cones))
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.max_threads, settings.presolve_enable = False, 1, False
    if not fixed:
        return lambda k: np.array(clarabel.DefaultSolver(*problems[k], settings).solve().x)
    solver = clarabel.DefaultSolver(*problems[0], settings)

    def solve(k: int) -> Array:
        solver.update(b=problems[k][3])
        return np.array(solver.solve().x)

    return solve


def with_qpsolvers(solver: str) -> Build:
    """Sparse solvers get all bounds as rows: qpsolvers takes 1 ms to stack them otherwise."""

    def build(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
        import qpsolvers

        problems: list[tuple[Any, ...]] = []
        for b in map(Blocks.of, programs):
            if solver in ("clarabel", "osqp"):
                (G, h), matrix = b.one_sided, sparse.csc_matrix
                problems.append((matrix(b.P), b.q, matrix(G), h, matrix(b.A), b.b))
            else:
                problems.append((b.P, b.q, b.G, b.h, b.A, b.b, b.lb, b.ub))
        solve: Any = qpsolvers.solve_qp
        options = TIGHT.get(solver, {})
        return lambda k: np.asarray(solve(*problems[k], solver=solver, **options))

    return build


def with_cvxpy(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    import cvxpy

    blocks = [Blocks.of(program) for program in programs]
    first = blocks[0]
    x, b = cvxpy.Variable(len(first.q)), cvxpy.Parameter(len(first.b))
    A: Any = first.A if fixed else cvxpy.Parameter(first.A.shape)
    G, h = first.one_sided
    cost = 0.5 * cvxpy.quad_form(x, cvxpy.psd_wrap(first.P)) + first.q @ x
    problem = cvxpy.Problem(cvxpy.Minimize(cost), [A @ x == b, G @ x <= h])

    def solve(k: int) -> Array:
        b.value = blocks[k].b
        if not fixed:
            A.value = blocks[k].A
        problem.solve(solver=cvxpy.CLARABEL)
        return np.asarray(x.value)

    return solve


def pseudo_inverse(programs: Sequence[QuadraticProgram], fixed: bool) -> Solve:
    """The weighted pseudo-inverse, H⁻¹ Aᵀ (A H⁻¹ Aᵀ)⁻¹ b: exact where there are no limits."""
    blocks = [Blocks.of(program) for program in programs]
    inverse = 1.0 / np.diagonal(blocks[0].P)

    def gain(A: Array) -> Array:
        scaled = inverse[:, None] * A.T
        return np.asarray(np.linalg.solve(A @ scaled, scaled.T).T, dtype=float)

    once = gain(blocks[0].A)
    if fixed:
        return lambda k: once @ blocks[k].b
    return lambda k: gain(blocks[k].A) @ blocks[k].b


def _ever(programs: Sequence[QuadraticProgram]) -> Array:
    return np.asarray(np.any([program.rows != 0 for program in programs], axis=0))


PEERS = (
    Peer("daqp, bare", "daqp", bare_daqp),
    Peer("quadprog", "quadprog", with_quadprog),
    Peer("piqp", "piqp", with_piqp),
    Peer("proxqp", "proxsuite", with_proxqp),
    Peer("OSQP, updated, eps 1e-6", "osqp", with_osqp),
    Peer("Clarabel", "clarabel", with_clarabel),
    Peer("qpsolvers + daqp", "qpsolvers", with_qpsolvers("daqp")),
    Peer("qpsolvers + quadprog", "quadprog", with_qpsolvers("quadprog")),
    Peer("qpsolvers + piqp", "piqp", with_qpsolvers("piqp")),
    Peer("qpsolvers + proxqp", "proxsuite", with_qpsolvers("proxqp")),
    Peer("qpsolvers + OSQP", "qpsolvers", with_qpsolvers("osqp")),
    Peer("qpsolvers + Clarabel", "qpsolvers", with_qpsolvers("clarabel")),
    Peer("cvxpy (DPP) + Clarabel", "cvxpy", with_cvxpy),
    Peer("pseudo-inverse, no limits", "numpy", pseudo_inverse),
)
