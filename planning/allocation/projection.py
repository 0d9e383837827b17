"""The nearest to what is asked: `minimise ½ ‖t‖² such that Sᵀ sum G_i F_i + t = Sᵀ wrench_b, F within limits`.

Distance is measured in the effective rows as they are (N and N·m side by side).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

from ..quadratic_program import EQUALITY_TOLERANCE, OPTIMAL, QPSolution, QuadraticProgram
from ..solvers import QuadraticSolver

SHORT_SLACK_RATIO = 0.1  # of the wrench asked for: a slack shorter than this is seen from farther away

STEEP_COST_FACTOR = 1e6


@dataclass(frozen=True, eq=False)
class Projection:
    """The slack t (k,) that is missing, and the unknowns, F (6n,) first, that reach the rest."""

    slack: Array
    wrenches: Array
    solution: QPSolution
    normal: Array  # (k,), along the slack: of the projection from farther away where the slack is short
    normal_solution: QPSolution

    @property
    def distance(self) -> float:
        return float(np.linalg.norm(self.slack))

    def is_feasible(self, target: Array) -> bool:
        """Whether what is missing is rounding."""
        return self.distance <= EQUALITY_TOLERANCE * max(1.0, float(np.abs(target).max(initial=0.0)))


def projection_program(program: QuadraticProgram, slack_map: Array) -> QuadraticProgram:
    """An allocation's program with a slack t (k,) in its last rows, minimising ½ ‖t‖² alone."""
    n, (m, k) = program.n, slack_map.shape
    other_rows = len(program.rows) - m
    hessian = np.diag(np.concatenate([np.zeros(n), np.ones(k)]))
    slack_rows = np.vstack([np.zeros((other_rows, k)), slack_map])
    free, name = np.full(k, np.inf), ("slack",) * k
    return replace(
        program,
        hessian=hessian,
        gradient=np.zeros(n + k),
        rows=np.hstack([program.rows, slack_rows]),
        lower=np.concatenate([program.lower[:n], -free, program.lower[n:]]),
        upper=np.concatenate([program.upper[:n], free, program.upper[n:]]),
        lower_names=program.lower_names[:n] + name + program.lower_names[n:],
        upper_names=program.upper_names[:n] + name + program.upper_names[n:],
        cones=tuple(replace(c, rows=np.hstack([c.rows, c.own(slack_rows)])) for c in program.cones),
        constant=0.0,
    )


def moved(near: QuadraticProgram, slack_map: Array, outward: Array) -> QuadraticProgram:
    """A projection of what is farther out by a slack (k,)."""
    lower, upper, shift = near.lower.copy(), near.upper.copy(), slack_map @ outward
    lower[-len(shift) :] += shift
    upper[-len(shift) :] += shift
    of_rows = np.concatenate([np.zeros(len(near.rows) - len(shift)), shift])
    cones = tuple(replace(cone, offset=cone.offset - cone.own(of_rows)) for cone in near.cones)
    return replace(near, lower=lower, upper=upper, cones=cones)


def project(solver: QuadraticSolver, program: QuadraticProgram, slack_map: Array) -> Projection:
    """The projection. Where what is missing is little, its multipliers are little too, and rounding blurs the
    normal: then it is taken from a point farther out along the same normal, whose projection is the same."""
    near = projection_program(program, slack_map)
    solution = _solved(solver, near)
    slack = _slack(solution, program.n)
    projection = Projection(slack, solution.x[: program.n], solution, slack, solution)
    values = program.upper[-len(slack_map) :][slack_map.any(axis=1)]
    scale = max(1.0, float(np.abs(values[np.isfinite(values)]).max(initial=0.0)))
    if not EQUALITY_TOLERANCE * scale < projection.distance < SHORT_SLACK_RATIO * scale:
        return projection
    outward = scale / projection.distance * slack
    far = solver.solve(moved(near, slack_map, outward))
    if far.status != OPTIMAL:
        return projection
    normal = _slack(far, program.n)
    projection = replace(projection, normal=normal, normal_solution=far)
    if np.linalg.norm(normal - outward) < projection.distance:
        return replace(projection, slack=normal - outward, wrenches=far.x[: program.n])
    return projection


def _solved(solver: QuadraticSolver, near: QuadraticProgram) -> QPSolution:
    """A short slack costs less than a solver's tolerance: where that fails, it costs `STEEP_COST_FACTOR` times more."""
    solution = solver.solve(near)
    if solution.status == OPTIMAL:
        return solution
    steep = solver.solve(replace(near, hessian=STEEP_COST_FACTOR * near.hessian))
    if steep.status != OPTIMAL:
        return solution
    z = tuple(multiplier / STEEP_COST_FACTOR for multiplier in steep.cone_multipliers)
    return QPSolution.checked(near, steep.x, steep.multipliers / STEEP_COST_FACTOR, z, steep.solver, steep.message)


def _slack(solution: QPSolution, n: int) -> Array:
    slack = solution.x[n:].copy()
    slack[np.abs(slack) < 1e-13 * max(1.0, float(np.abs(slack).max(initial=0.0)))] = 0.0
    return slack
