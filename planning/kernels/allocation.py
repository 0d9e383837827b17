"""One call of a planner at given contacts: new data into the program, its solution, and the proof.

Contacts enter the last rows affinely, `base + x slope_x + y slope_y + z slope_z` for an arm at (x, y, z); base and
slopes are taken from `AllocationTemplate`, which alone knows the formula.
"""

from __future__ import annotations

from cartgrasp.contacts import MAX_POSITION
from cartgrasp.frames import Array

from .dual_active_set import INFEASIBLE, OPTIMAL, REFUSED, UNPROVEN, solve
from .jit import compiled, entry
from .proof import EQUALITY_TOLERANCE, ray_value, verify, wrench_scale
from .working_set import Ints
from .workspace import Workspace, unpack


@compiled
def solve_program(floats: Array, ints: Ints) -> int:
    """OPTIMAL and INFEASIBLE are proven. After any other answer the next solve begins anew."""
    w = unpack(floats, ints)
    status = solve(w.problem, w.held, w.claim.x, w.claim.y)
    if status == OPTIMAL and not verify(w.claim, w.found):
        status = UNPROVEN
    if status == INFEASIBLE and not ray_value(w.claim) > EQUALITY_TOLERANCE * wrench_scale(w.claim):
        status = UNPROVEN
    if status != OPTIMAL:
        w.held.size[0] = 0
    return status


@entry
def allocate(floats: Array, ints: Ints, wrench: tuple[float, float, float], moved: bool) -> int:
    """Solves for a wrench (fx, fy, tau) on the cart in {b}, at other `points` than before if `moved`. What is found
    stands in the workspace."""
    w = unpack(floats, ints)
    ask(w, wrench)
    if moved:
        for arm in range(len(w.points)):
            for c in range(3):
                if not abs(w.points[arm, c]) <= MAX_POSITION:
                    return REFUSED
        move(w)
    return solve_program(floats, ints)


@compiled
def ask(w: Workspace, wrench: tuple[float, float, float]) -> None:
    """Sᵀ wrench into the equalities."""
    limits, basis = w.problem.limits, w.basis
    first = limits.shape[1] - basis.shape[1]
    for i in range(basis.shape[1]):
        value = basis[0, i] * wrench[0] + basis[1, i] * wrench[1] + basis[2, i] * wrench[2]
        limits[0, first + i] = limits[1, first + i] = value


@compiled
def move(w: Workspace) -> None:
    """The rows that depend on contacts, and their lifted normals, at the workspace's points."""
    rows, lifted, inverse, affine, points = w.problem.rows, w.problem.lifted, w.inverse, w.affine, w.points
    moving, n = affine.shape[1], rows.shape[1]
    start = len(rows) - moving
    w.held.size[0] = 0
    for arm in range(len(points)):
        x, y, z = points[arm, 0], points[arm, 1], points[arm, 2]
        for i in range(moving):
            for j in range(6 * arm, 6 * arm + 6):
                rows[start + i, j] = affine[0, i, j] + x * affine[1, i, j] + y * affine[2, i, j] + z * affine[3, i, j]
    for i in range(start, len(rows)):
        for j in range(n):
            lifted[i, j] = 0.0
        for k in range(n):
            if rows[i, k] != 0.0:
                for j in range(n):
                    lifted[i, j] += rows[i, k] * inverse[k, j]
