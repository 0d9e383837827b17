"""A dual active-set method (Goldfarb and Idnani 1983) for `minimise ½ xᵀHx + fᵀx, lower <= G x <= upper`, H > 0.

With A the limits held and y their multipliers (signs as in quadratic_program.py),

    x = -H⁻¹ (f + G_Aᵀ y),    G_A x = the limits held,    y >= 0 at upper limits, <= 0 at lower ones:

the optimum of a problem with fewer limits. Each step takes up the limit that x breaks most, p, and moves its
multiplier while those held keep x on A: y_A falls by `c = (G_A H⁻¹ G_Aᵀ)⁻¹ G_A V_p` for each unit of it, and x by
`z = V_p - V_Aᵀ c`. A limit whose multiplier reaches zero is let go. Where z = 0 and nothing can be let go, y is a
Farkas ray: G y = 0 for what no x can keep. Every full step raises the dual cost, so no set comes twice but for
rounding: `MAX_STEPS_PER_LIMIT` ends that.

It begins with what was held at the last solve, as far as multipliers there have their sign.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

from .jit import compiled
from .working_set import Held, Problem, direction, hold, image, let_go, product, solve_lower, solve_upper, subtract

OPTIMAL, INFEASIBLE, FAILED, UNPROVEN, REFUSED = range(5)
FEASIBILITY_TOLERANCE = 1e-11  # of the largest equality's value, at least 1
DEPENDENCE_TOLERANCE = 1e-12  # of a normal's square: what is left of it beside the normals held
MAX_STEPS_PER_LIMIT = 10  # per limit


@compiled
def solve(problem: Problem, held: Held, x: Array, y: Array) -> int:
    """Fills x (n,) and y (n + m,), which is the ray when infeasible. `held` is of the last solve with the same
    rows, or holds nothing."""
    scale = begin(problem, held, x)
    for i in range(len(y)):
        y[i] = 0.0
    for _ in range(MAX_STEPS_PER_LIMIT * len(y)):
        worst, excess = most_broken(problem, x)
        if abs(excess) <= FEASIBILITY_TOLERANCE * scale or holds(held, worst):
            correct(problem, held, x)
            worst, excess = most_broken(problem, x)
        if abs(excess) <= FEASIBILITY_TOLERANCE * scale or holds(held, worst):
            for k in range(held.size[0]):
                if held.side[k] * held.dual[k] >= 0.0:
                    y[held.limit[k]] = held.dual[k]
            return OPTIMAL
        if not take_up(problem, held, worst, excess, x):
            y[worst] = np.sign(excess)
            for k in range(held.size[0]):
                y[held.limit[k]] = -y[worst] * held.change[k]
            held.size[0] = 0
            return INFEASIBLE
    held.size[0] = 0
    return FAILED


@compiled
def begin(problem: Problem, held: Held, x: Array) -> float:
    """x and multipliers of what is held, and of the equalities if that is nothing; limits with a multiplier of the
    wrong sign are let go. Returns the largest value of an equality, at least 1."""
    limits, side, dual = problem.limits, held.side, held.dual
    scale, at_first = 1.0, held.size[0] == 0
    for i in range(limits.shape[1]):
        if limits[0, i] == limits[1, i]:
            scale = max(scale, abs(limits[1, i]))
            if at_first:
                hold_equality(problem, held, i)
    while True:
        for k in range(held.size[0]):
            dual[k] = 0.0
        for j in range(len(x)):
            x[j] = problem.free[j]
        correct(problem, held, x)
        before = held.size[0]
        for k in range(before - 1, -1, -1):
            if side[k] * dual[k] < 0.0:
                let_go(held, k)
        if held.size[0] == before:
            return scale


@compiled
def hold_equality(problem: Problem, held: Held, i: int) -> None:
    """Unless its normal depends on those held: then it is met as well, or the program is infeasible."""
    if held.size[0] < len(problem.free):
        left = direction(problem, held, i)
        if left > DEPENDENCE_TOLERANCE * product(problem, i, i):
            hold(held, i, 0.0, left)


@compiled
def most_broken(problem: Problem, x: Array) -> tuple[int, float]:
    """The limit that x breaks most, and by how much: above 0 at its upper one, below at its lower one."""
    limits, worst, excess = problem.limits, -1, 0.0
    for i in range(limits.shape[1]):
        value = image(problem, i, x)
        if value - limits[1, i] > abs(excess):
            worst, excess = i, value - limits[1, i]
        elif limits[0, i] - value > abs(excess):
            worst, excess = i, value - limits[0, i]
    return worst, excess


@compiled
def holds(held: Held, p: int) -> bool:
    """What is held is broken by rounding alone."""
    found = False
    for k in range(held.size[0]):
        found |= held.limit[k] == p
    return found


@compiled
def take_up(problem: Problem, held: Held, p: int, excess: float, x: Array) -> bool:
    """Moves until limit p is kept and held; False if that can't be."""
    side, multiplier, square = np.sign(excess), 0.0, product(problem, p, p)
    dual, change, z = held.dual, held.change, held.z
    while True:
        left = direction(problem, held, p)
        independent = left > DEPENDENCE_TOLERANCE * square and held.size[0] < len(x)
        first, step = first_to_go(held, side, abs(excess) / left if independent else np.inf)
        if step == np.inf:
            return False
        for k in range(held.size[0]):
            dual[k] -= side * step * change[k]
        multiplier += side * step
        if independent:
            for j in range(len(x)):
                x[j] -= side * step * z[j]
            excess -= side * step * left
        if first < 0:
            fixed = problem.limits[0, p] == problem.limits[1, p]
            hold(held, p, 0.0 if fixed else side, left)
            dual[held.size[0] - 1] = multiplier
            return True
        let_go(held, first)


@compiled
def first_to_go(held: Held, side: float, full: float) -> tuple[int, float]:
    """The limit held whose multiplier reaches zero before the full step, -1 if none does; and the step."""
    first, step, sides, dual, change = -1, full, held.side, held.dual, held.change
    for k in range(held.size[0]):
        falls = sides[k] * side * change[k]
        if falls > 0.0:
            reach = max(0.0, sides[k] * dual[k]) / falls
            if reach < step:
                first, step = k, reach
    return first, step


@compiled
def correct(problem: Problem, held: Held, x: Array) -> None:
    """One step of refinement: multipliers and x such that the limits held are met."""
    count, limit, dual, missing = held.size[0], held.limit, held.dual, held.column
    for k in range(count):
        i = limit[k]
        missing[k] = image(problem, i, x) - problem.limits[0 if held.side[k] < 0.0 else 1, i]
    solve_lower(held, missing)
    solve_upper(held, missing)
    for k in range(count):
        dual[k] += missing[k]
    for j in range(len(x)):
        x[j] = problem.free[j]
    subtract(problem, held, dual, x)
