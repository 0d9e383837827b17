"""`WrenchPlanner(solver=...)` for every solver that is installed: what it is worth alone, what the polish makes of it,
and what it costs beside the compiled road and beside our own calls of daqp and Clarabel."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable

import numpy as np
import qpsolvers
from scipy import sparse

from cartgrasp import Arm, Friction
from cartgrasp.frames import Array
from planning import WrenchPlanner, build_allocation
from planning.quadratic_program import QuadraticProgram
from planning.solvers.cvxpy_problem import takes_cones
from planning.solvers.named_solver import SOLVER_ERRORS, NamedSolver

from .measuring import Competitor, interleave
from .peers import Blocks, most
from .report import Result, Table, timed_table
from .scene import CART, hand

PROBLEMS = 200
NEAR = 1e-6
OURS, BEFORE = "compiled (the default)", "our daqp and Clarabel"
NOTE = f"""Two arms, boxes, a friction pyramid of 4 sides on each. {PROBLEMS} wrenches are drawn at 5 to 100 % of
the most that the arms can give in a random direction, and as many at 1 ± {NEAR:g} of it. `verifies alone` counts
proposals that the proof accepts as they come, `polished` what is proven after the polish, `left` what Clarabel had to
answer. `found` counts problems that can be solved and of which qpsolvers says so, at the solver's own tolerances, and
`not found` those that can't. `wrong` counts statuses of plans that differ from what is known, `apart` is the largest
difference of a wrench to the compiled road's, over the largest component. Times are of whole plans, with their proofs;
`{BEFORE}` is the general road without `solver`: before `warm_up`, and for what isn't compiled (segments,
cones)."""


def run(rounds: int) -> Result:
    names = sorted(qpsolvers.available_solvers)
    tables = [_worth(names), _times("the wrench new", names, rounds, "µs", *_allocation())]
    tables.append(_times("contacts chosen on segments", names, max(3, rounds // 20), "ms", *_segments()))
    conic = [name for name in names if takes_cones(name)]
    tables.append(_times("friction cones (through cvxpy)", conic, max(3, rounds // 10), "ms", *_cones()))
    return Result("Any solver by its name", NOTE, tuple(tables))


def _worth(names: list[str]) -> Table:
    arms, wrenches = _allocation()
    contacts = {arm.name: np.array(arm.contacts.first) for arm in arms}
    random, rows = np.random.default_rng(1), []
    inside = [random.uniform(0.05, 1.0) * wrench for wrench in wrenches]
    problems = [(w, True) for w in inside]
    problems += [(wrench * (1 - NEAR if k % 2 else 1 + NEAR), bool(k % 2)) for k, wrench in enumerate(wrenches)]
    compiled, begin = WrenchPlanner(CART, arms), os.getloadavg()[0]
    compiled.warm_up()
    for name in names:
        solver, planner = NamedSolver(name), WrenchPlanner(CART, arms, solver=name)
        alone, polished, left, found, wrong, apart = 0, 0, 0, [0, 0], 0, 0.0
        for wrench, feasible in problems:
            plan, reference = planner.plan_or_hold(wrench), compiled.plan_or_hold(wrench)
            wrong += plan.status != ("optimal" if feasible else "infeasible")
            program = build_allocation(CART, arms, contacts, wrench)
            found[feasible] += _finds(program, name) == feasible
            if feasible:
                alone += solver.solve(program).status == "optimal"
                polished += plan.solver == f"{name}, polished"
                left += plan.solver.startswith("clarabel") and plan.message.startswith("fallback")
                apart = max(apart, _apart(plan.wrenches, reference.wrenches))
        n = sum(feasible for _, feasible in problems)
        said = f"{found[True]} of {n}", f"{found[False]} of {len(problems) - n}"
        counts = f"{alone} of {n}", str(polished), str(left), f"{wrong} of {len(problems)}"
        rows.append((name, *said, *counts, f"{apart:.0e}"))
    columns = ("", "found", "not found", "verifies alone", "polished", "left", "wrong", "apart")
    return Table("What is proven", columns, tuple(rows), (begin, os.getloadavg()[0]), len(problems))


def _finds(program: QuadraticProgram, name: str) -> bool:
    """What qpsolvers says, at the solver's own tolerances."""
    block = Blocks.of(program)
    (G, h), as_asked = block.one_sided, sparse.csc_matrix if name in qpsolvers.sparse_solvers else np.asarray
    problem = qpsolvers.Problem(as_asked(block.P), block.q, as_asked(G), h, as_asked(block.A), block.b)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return bool(qpsolvers.solve_problem(problem, solver=name).found)
    except SOLVER_ERRORS:
        return False


def _apart(ours: dict[str, Array], theirs: dict[str, Array]) -> float:
    x, y = (np.concatenate(list(wrenches.values())) for wrenches in (ours, theirs))
    return float(np.abs(x - y).max() / max(1.0, np.abs(y).max()))


def _times(title: str, names: list[str], rounds: int, unit: str, arms: list[Arm], wrenches: list[Array]) -> Table:
    planners = {BEFORE: WrenchPlanner(CART, arms)} | {name: WrenchPlanner(CART, arms, solver=name) for name in names}
    ours = BEFORE
    if all(not arm.contacts.segments and arm.friction.sides != "exact" for arm in arms if arm.friction):
        planners, ours = {OURS: WrenchPlanner(CART, arms)} | planners, OURS
        planners[OURS].warm_up()

    def calling(planner: WrenchPlanner) -> Competitor:
        return lambda k: planner.plan(0.8 * wrenches[k % len(wrenches)])

    burst = 10 if unit == "µs" else 1
    found = interleave({name: calling(planner) for name, planner in planners.items()}, rounds, burst)
    before = found.times[BEFORE].median
    over = {name: f"{times.median / before:.1f}" for name, times in found.times.items()}
    return timed_table(f"Time of a plan: {title}", found, ours, unit, {f"over {BEFORE}": over})


def _allocation() -> tuple[list[Arm], list[Array]]:
    arms = [hand(f"arm{i}", [(-0.25, y, 1.0)]) for i, y in enumerate((-0.15, 0.15))]
    return arms, _edge(lambda wrench: build_allocation(CART, arms, _first(arms), wrench))


def _segments() -> tuple[list[Arm], list[Array]]:
    ends = [(-0.25, -0.25, 1.0), (-0.25, 0.25, 1.0)]
    limits = {"force_limit": (60.0, 60.0, 40.0), "moment_limit": (8.0, 8.0, 6.0)}
    return [Arm(name, segment=ends, friction=Friction(0.6), **limits) for name in ("one", "other")], _allocation()[1]


def _cones() -> tuple[list[Arm], list[Array]]:
    limits = {"force_limit": (60.0, 60.0, 40.0), "moment_limit": (8.0, 8.0, 6.0), "friction": Friction(0.6, "exact")}
    arms = [Arm(f"arm{i}", [(-0.25, y, 1.0)], **limits) for i, y in enumerate((-0.15, 0.15))]
    return arms, _allocation()[1]


def _first(arms: list[Arm]) -> dict[str, Array]:
    return {arm.name: np.array(arm.contacts.first) for arm in arms}


def _edge(program: Callable[[Array], QuadraticProgram]) -> list[Array]:
    """The largest wrenches that can be given along random directions."""
    random, found = np.random.default_rng(0), []
    for _ in range(PROBLEMS):
        direction = np.array([1.0, 0.0, random.uniform(-0.5, 0.5)])
        found.append(most(program(direction)) * direction)
    return found
