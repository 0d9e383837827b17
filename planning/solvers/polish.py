"""Newton's method on the KKT system of the active set: takes a solver's 1e-6 to rounding.

Active rows are equalities. A cone that is active away from its apex is the smooth equality `s_0 - ‖s_r‖ = 0`
with multiplier z_0 (its curvature enters the Hessian); at its apex it is `s = 0`. Least-squares steps let the
Hessian and the active rows be rank deficient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from planning.quadratic_program import OPTIMAL, Cone, QPSolution, QuadraticProgram

CONE_STEPS, MAX_ROUNDS = 4, 10
POLISH_TOLERANCE = 1e-12  # of the largest value


@dataclass
class _ActiveCone:
    cone: Cone
    apex: bool
    multiplier: Array  # z_0 alone, or all of z at the apex

    def linearised(self, x: Array) -> tuple[Array, Array, Array]:
        """Rows, residual and curvature of the Lagrangian at x."""
        s = self.cone.offset + self.cone.rows @ x
        if self.apex:
            return self.cone.rows, s, np.zeros((len(x), len(x)))
        length = float(np.linalg.norm(s[1:]))
        direction, rest = s[1:] / length, self.cone.rows[1:]
        across = rest - np.outer(direction, direction @ rest)
        curvature = self.multiplier[0] / length * (rest.T @ across)
        return (self.cone.rows[0] - direction @ rest)[None], np.array([s[0] - length]), curvature

    def full(self, x: Array) -> Array:
        if self.apex:
            return self.multiplier
        s = self.cone.offset + self.cone.rows @ x
        return np.concatenate([self.multiplier, -self.multiplier * s[1:] / np.linalg.norm(s[1:])])


def polish(program: QuadraticProgram, solution: QPSolution) -> QPSolution:
    """Where the rows that look active don't lead to an answer that verifies, those that pull the wrong way are left
    out, those that are broken are held, and so on: a primal-dual active set method (Hintermüller and others, 2002)."""
    active, target = _active_rows(program, solution)
    for _ in range(MAX_ROUNDS):
        found = _settled(program, solution, active, target)
        if found.status == OPTIMAL or program.cones or not np.isfinite(found.x).all():
            return found
        before, (active, target) = active, _corrected(program, found, active, target)
        if np.array_equal(before, active):
            break
    return found


def _settled(program: QuadraticProgram, solution: QPSolution, active: Array, target: Array) -> QPSolution:
    """From a solution, with these rows of (x, R x) held at `target` (n + m,)."""
    x, y = solution.x.copy(), solution.multipliers
    cones = _active_cones(program, solution)
    rows, held = program.stacked[program.n :][active], target[active]
    dual = y[active].copy()
    for _ in range(CONE_STEPS if cones else 2):
        step, dual_step = _newton_step(program, (x, dual), (rows, held), list(cones.values()))
        x, start = x + step, len(dual)
        dual = dual + dual_step[:start]
        for cone in cones.values():
            stop = start + len(cone.multiplier)
            cone.multiplier = cone.multiplier + dual_step[start:stop]
            start = stop
    if not np.isfinite(x).all():
        return solution
    full = np.zeros(len(y))
    full[active] = dual
    z = [cones[i].full(x) if i in cones else np.zeros(len(cone.offset)) for i, cone in enumerate(program.cones)]
    return QPSolution.checked(program, x, full, z, f"{solution.solver}, polished", solution.message)


def _newton_step(
    program: QuadraticProgram, point: tuple[Array, Array], held: tuple[Array, Array], cones: list[_ActiveCone]
) -> tuple[Array, Array]:
    (x, dual), (rows, target) = point, held
    hessian = program.hessian.copy()
    gradient = program.hessian @ x + program.gradient + dual @ rows
    matrices, residuals = [rows], [rows @ x - target]
    for cone in cones:
        cone_rows, residual, curvature = cone.linearised(x)
        hessian += curvature
        gradient = gradient - cone.multiplier @ cone_rows
        matrices.append(-cone_rows)
        residuals.append(-residual)
    matrix, residual = np.vstack(matrices), np.concatenate(residuals)
    kkt = np.block([[hessian, matrix.T], [matrix, np.zeros((len(matrix), len(matrix)))]])
    step = np.linalg.lstsq(kkt, -np.concatenate([gradient, residual]), rcond=1e-13)[0]
    return step[: len(x)], step[len(x) :]


def _active_rows(program: QuadraticProgram, solution: QPSolution) -> tuple[Array, Array]:
    """Which entries of (x, R x) are held, and at what any would be, both (n + m,)."""
    y, values = solution.multipliers, program.stacked[program.n :] @ solution.x
    slack = np.where(y > 0, program.upper - values, values - program.lower)
    fixed = program.sense | (program.lower == program.upper)
    active = fixed | ((y != 0) & (np.abs(y) > slack))
    return active, np.where(fixed | (y > 0), program.upper, program.lower)


def _corrected(program: QuadraticProgram, found: QPSolution, active: Array, target: Array) -> tuple[Array, Array]:
    y, values = found.multipliers, program.stacked[program.n :] @ found.x
    room = POLISH_TOLERANCE * max(1.0, float(np.abs(values).max(initial=0.0)))
    fixed = program.sense | (program.lower == program.upper)
    above, below = values > program.upper + room, values < program.lower - room
    pulls = np.where(target == program.upper, y >= 0, y <= 0)
    held = fixed | (active & pulls) | above | below
    return held, np.where(above, program.upper, np.where(below, program.lower, target))


def _active_cones(program: QuadraticProgram, solution: QPSolution) -> dict[int, _ActiveCone]:
    """At the apex s is smaller than the multiplier's way off the boundary; on the boundary both are long."""
    found = {}
    for i, (cone, z) in enumerate(zip(program.cones, solution.cone_multipliers, strict=True)):
        s = cone.offset + cone.rows @ solution.x
        s_off, z_off = s[0] - np.linalg.norm(s[1:]), z[0] - np.linalg.norm(z[1:])
        if z[0] <= s_off:
            continue
        apex = len(s) == 1 or bool(s[0] < z_off)
        found[i] = _ActiveCone(cone, apex, z.copy() if apex else z[:1].copy())
    return found
