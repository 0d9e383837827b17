"""When the arms can't give what is asked: the nearest they can, and a Farkas certificate that they can't.

The projection `minimise ½ ‖t‖² such that Sᵀ sum G_i F_i + t = Sᵀ wrench_b, F within limits` measures distance
in the effective rows as they are (N and N·m side by side). At its optimum t is normal to what the arms can
give, so

    t · Sᵀ wrench_b  >  max over F within limits of  t · Sᵀ sum G_i F_i,

and the multipliers of the limits in the projection name those that conflict. The right side is bounded by
weak duality (see duality.py) in plain numpy: the inequality is what `verified` means.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array

from .allocation_template import AllocationTemplate, in_words
from .duality import Cut, farkas_cut, infeasible_by
from .quadratic_program import EQUALITY_TOLERANCE, OPTIMAL, Cone, QPSolution, QuadraticProgram
from .solvers import QuadraticSolver, solve_with_clarabel

FORCE_WORDS = frozenset({"fx", "fy", "fz", "payload", "force"})
FAR = 0.1  # of the wrench asked for: a slack shorter than this is seen from farther away
STEEP = 1e6
SINGLE_DIRECTIONS = {
    "fx": "forward force",
    "-fx": "backward force",
    "fy": "force to the left",
    "-fy": "force to the right",
    "tau": "counter-clockwise moment",
    "-tau": "clockwise moment",
}


@dataclass(frozen=True, eq=False)
class Nearest:
    """The feasible cart wrench (3,) in {b} nearest to the one asked for, in effective rows, with its
    least-effort plan, its `missing` part of each effective row (N, N·m), and the solved program."""

    wrench: Array
    distance: float
    missing: Mapping[str, float]
    contacts: Mapping[str, Array]
    wrenches: Mapping[str, Array]
    effort: float
    program: QuadraticProgram
    solution: QPSolution

    def may_stand_in(self, most: float) -> bool:
        """Whether it misses what was asked by `most` or less, and was verified."""
        return self.distance <= most and self.solution.residuals.feasible

    def as_dict(self) -> dict[str, Any]:
        arms = {
            name: {"contact": self.contacts[name].tolist(), "wrench": wrench.tolist()}
            for name, wrench in self.wrenches.items()
        }
        return {
            "wrench": self.wrench.tolist(),
            "distance": self.distance,
            "arms": arms,
            "effort": self.effort,
        }


@dataclass(frozen=True)
class Certificate:
    """Why a wrench is out of reach. In the unit `direction` of (fx, fy, tau), `asked` is more than `most`,
    the most that `limits` (name: value) allow. Empty direction: it is about the hands' distance or reach, in m, or
    about limits that no wrench keeps, in N, instead. `remedy` names contacts that would do, where some were found."""

    words: str
    asked: float
    most: float
    direction: tuple[float, ...] = ()
    limits: Mapping[str, float] = field(default_factory=dict)
    nearest: Nearest | None = None
    remedy: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    @property
    def verified(self) -> bool:
        return self.asked > self.most

    def as_dict(self) -> dict[str, Any]:
        most = self.most if np.isfinite(self.most) else None
        numbers = {"asked": self.asked, "most": most, "direction": list(self.direction)}
        remedy = {"remedy": {name: list(point) for name, point in self.remedy.items()}} if self.remedy else {}
        return {"words": self.words, **numbers, "limits": dict(self.limits), **remedy}


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
    rows = np.hstack([program.rows, np.vstack([np.zeros((other_rows, k)), slack_map])])
    free, name = np.full(k, np.inf), ("slack",) * k
    return replace(
        program,
        hessian=hessian,
        gradient=np.zeros(n + k),
        rows=rows,
        lower=np.concatenate([program.lower[:n], -free, program.lower[n:]]),
        upper=np.concatenate([program.upper[:n], free, program.upper[n:]]),
        lower_names=program.lower_names[:n] + name + program.lower_names[n:],
        upper_names=program.upper_names[:n] + name + program.upper_names[n:],
        cones=tuple(Cone(c.name, np.hstack([c.rows, np.zeros((len(c.offset), k))]), c.offset) for c in program.cones),
        constant=0.0,
    )


def project(solver: QuadraticSolver, program: QuadraticProgram, slack_map: Array) -> Projection:
    """The projection. Where what is missing is little, its multipliers are little too, and rounding blurs the
    normal: then it is taken from a point farther out along the same normal, whose projection is the same."""
    near = projection_program(program, slack_map)
    solution = _solved(solver, near)
    slack = _slack(solution, program.n)
    projection = Projection(slack, solution.x[: program.n], solution, slack, solution)
    values = program.upper[-len(slack_map) :][slack_map.any(axis=1)]
    scale = max(1.0, float(np.abs(values[np.isfinite(values)]).max(initial=0.0)))
    if not EQUALITY_TOLERANCE * scale < projection.distance < FAR * scale:
        return projection
    outward = scale / projection.distance * slack
    lower, upper = near.lower.copy(), near.upper.copy()
    lower[-len(slack_map) :] += slack_map @ outward
    upper[-len(slack_map) :] += slack_map @ outward
    far = solver.solve(replace(near, lower=lower, upper=upper))
    if far.status != OPTIMAL:
        return projection
    normal = _slack(far, program.n)
    projection = replace(projection, normal=normal, normal_solution=far)
    if np.linalg.norm(normal - outward) < projection.distance:
        return replace(projection, slack=normal - outward, wrenches=far.x[: program.n])
    return projection


def _solved(solver: QuadraticSolver, near: QuadraticProgram) -> QPSolution:
    """A short slack costs less than a solver's tolerance: where that fails, its cost is taken `STEEP` times."""
    solution = solver.solve(near)
    if solution.status == OPTIMAL:
        return solution
    steep = solver.solve(replace(near, hessian=STEEP * near.hessian))
    if steep.status != OPTIMAL:
        return solution
    z = tuple(multiplier / STEEP for multiplier in steep.cone_multipliers)
    return QPSolution.checked(near, steep.x, steep.multipliers / STEEP, z, steep.solver, steep.message)


def _slack(solution: QPSolution, n: int) -> Array:
    slack = solution.x[n:].copy()
    slack[np.abs(slack) < 1e-13 * max(1.0, float(np.abs(slack).max(initial=0.0)))] = 0.0
    return slack


def nearest_plan(
    template: AllocationTemplate, contacts: Array, projection: Projection, program: QuadraticProgram
) -> Nearest:
    """Least effort among the wrenches that reach the nearest point; `program` is the infeasible
    allocation."""
    reachable = program.with_equality_value(program.equality[1] - projection.slack)
    solution = QuadraticSolver().solve(reachable)
    if solution.status != OPTIMAL:
        solution = solve_with_clarabel(reachable)
    if solution.status != OPTIMAL:
        cones = [np.zeros(len(cone.offset)) for cone in reachable.cones]
        solution = QPSolution.checked(
            reachable, projection.wrenches, np.zeros(len(reachable.upper)), cones, "projection"
        )
    wrenches = solution.x[: template.n]
    parts = wrenches.reshape(-1, 6)
    return Nearest(
        wrench=_total(template, contacts, parts),
        distance=projection.distance,
        missing=dict(zip(template.row_names, projection.slack.tolist(), strict=True)),
        contacts=dict(zip(template.names, contacts, strict=True)),
        wrenches=dict(zip(template.names, parts, strict=True)),
        effort=template.effort(wrenches),
        program=reachable,
        solution=solution,
    )


def certify(template: AllocationTemplate, contacts: Array, projection: Projection, target: Array) -> Certificate | None:
    """The separating direction with the limits that hold it; None if it doesn't verify."""
    if not np.isfinite(projection.slack).all() or projection.distance == 0.0:
        return None
    cut = farkas_cut(template, projection.normal_solution, projection.normal, target)
    margin = float(cut.value(template.contact_rows(contacts)))
    normal = -cut.multipliers[-len(target) :]
    asked = float(normal @ target)
    if margin <= 1e-12 * max(1.0, float(np.abs(target).max())):
        return None
    direction = template.basis_b @ normal
    limits = conflicting_limits(template, contacts, cut, projection.normal_solution)
    words = _words(limits, direction, (asked, asked - margin))
    return Certificate(words, asked, asked - margin, tuple(direction.tolist()), limits)


def contradiction(template: AllocationTemplate, program: QuadraticProgram) -> Certificate | None:
    """Why no wrench at all is within limits, whatever is asked: the cart's limits, with the arms' held, are missed
    by a least distance (N). None if that doesn't verify."""
    c, k = len(template.cart_rows.low), template.basis_b.shape[1]
    if c == 0:
        return None
    rows = len(program.rows) - k
    stop = program.n + rows
    alone = replace(
        program,
        rows=program.rows[:rows],
        lower=program.lower[:stop],
        upper=program.upper[:stop],
        lower_names=program.lower_names[:stop],
        upper_names=program.upper_names[:stop],
        n_equalities=0,
    )
    projection = project(QuadraticSolver(always_feasible=True), alone, np.eye(c))
    if projection.solution.status != OPTIMAL or projection.distance == 0.0:
        return None
    least = infeasible_by(alone, projection.normal_solution, projection.normal)
    if least <= 0:
        return None
    missed = np.abs(projection.slack) > 1e-7 * projection.distance
    names = [
        template.cart_rows.low_names[i] if projection.slack[i] > 0 else template.cart_rows.high_names[i]
        for i in np.flatnonzero(missed)
    ]
    limits = {name: abs(float(t)) for name, t in zip(names, projection.slack[missed], strict=True)}
    parts = "; ".join(f"{name} by {value:.6g} N" for name, value in limits.items())
    return Certificate(
        f"{parts}: missed at least that much by any wrench that the arms can give", least, 0.0, (), limits
    )


def conflicting_limits(
    template: AllocationTemplate, contacts: Array, cut: Cut, solution: QPSolution
) -> dict[str, float]:
    """Names and values of the limits that hold the arms back in the direction of a ray."""
    fixed, cart, found = template.fixed, template.cart_rows, dict[str, float]()
    slope = (cut.linear + cut.multipliers @ template.contact_rows(contacts)).ravel()
    smallest = 1e-7 * float(np.abs(slope).max())
    for j in np.flatnonzero(np.abs(slope) > smallest):
        names, values = (fixed.lower_names, fixed.lower) if slope[j] > 0 else (fixed.upper_names, fixed.upper)
        found[names[j]] = float(values[j])
    smallest = 1e-7 * float(np.abs(solution.multipliers).max())
    dual = solution.multipliers[len(solution.x) :][: len(fixed.limits) + len(cart.low)]
    lows = zip(fixed.low_names + cart.low_names, [*fixed.low_limits, *cart.low], strict=True)
    highs = zip(fixed.names + cart.high_names, [*fixed.limits, *cart.high], strict=True)
    for y, low, high in zip(dual, lows, highs, strict=True):
        if abs(y) > smallest:
            name, value = high if y > 0 else low
            found[name] = float(value)
    pairs = zip(fixed.cones, solution.cone_multipliers, strict=True)
    found.update({cone.name: 0.0 for cone, z in pairs if z[0] > smallest})
    return found


def _words(limits: Mapping[str, float], direction: Array, numbers: tuple[float, float]) -> str:
    name = in_words(direction)
    unit = " N" if not direction[2] else " N·m" if not direction[:2].any() else ""
    of_what = SINGLE_DIRECTIONS.get(name, f"{name}" if unit else f"{name} (fx, fy in N, tau in N·m)")
    parts = []
    for limit, value in limits.items():
        words = limit.split()
        is_force = FORCE_WORDS.intersection(words)
        bound = f" {abs(value):.6g} {'N' if is_force else 'N·m'}" if words[-1] in ("lower", "upper") else ""
        parts.append(limit + bound)
    asked, most = (f"{round(number, 9) + 0.0:.6g}{unit}" for number in numbers)
    subject = "together they give" if len(parts) > 1 else "it gives"
    return f"{'; '.join(parts)}: {subject} at most {most} of {of_what}, {asked} is asked"


def _total(template: AllocationTemplate, contacts: Array, wrenches: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->i", grasp_map_planar(contacts, template.yaws), wrenches))
