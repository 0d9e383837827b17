"""When the arms can't give what is asked: the nearest they can, and a Farkas certificate that they can't.

At the optimum of the projection (projection.py) the missing t is normal to what the arms can give, so

    t · Sᵀ wrench_b  >  max over F within limits of  t · Sᵀ sum G_i F_i,

and the multipliers of the limits in the projection name those that conflict. The right side is bounded by
weak duality (see duality.py) in plain numpy: the inequality is what `verified` means.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.frames import Array

from ..quadratic_program import OPTIMAL, Cone, QPSolution, QuadraticProgram
from ..solvers import QuadraticSolver, solve_with_clarabel
from .allocation_template import AllocationTemplate, in_words
from .duality import Cut, farkas_cut
from .projection import Projection

NEGLIGIBLE_MULTIPLIER_RATIO = 1e-7  # of the largest: below it is rounding

SINGLE_DIRECTIONS = {
    "fx": "forward force",
    "-fx": "backward force",
    "fy": "force to the left",
    "-fy": "force to the right",
    "tau": "counter-clockwise moment",
    "-tau": "clockwise moment",
}


class Bound(NamedTuple):
    """A limit's value, and its unit: that of the components of wrenches that it adds up; empty of a mixture."""

    value: float
    unit: str


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
        arms = arms_as_dict(self.contacts, self.wrenches)
        return {"wrench": self.wrench.tolist(), "distance": self.distance, "arms": arms, "effort": self.effort}


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


def arms_as_dict(contacts: Mapping[str, Array], wrenches: Mapping[str, Array]) -> dict[str, Any]:
    """What each arm gives, and where, for JSON."""
    return {name: {"contact": contacts[name].tolist(), "wrench": wrench.tolist()} for name, wrench in wrenches.items()}


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
        wrench=np.einsum("nij,nj->i", grasp_map_planar(contacts, template.yaws), parts),
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
    bounds = conflicting_limits(template, contacts, cut, projection.normal_solution)
    words = _words(bounds, direction, (asked, asked - margin))
    limits = {name: bound.value for name, bound in bounds.items()}
    return Certificate(words, asked, asked - margin, tuple(direction.tolist()), limits)


def conflicting_limits(
    template: AllocationTemplate, contacts: Array, cut: Cut, solution: QPSolution
) -> dict[str, Bound]:
    """The limits that hold the arms back in the direction of a ray, by name. Those that aren't there don't: against
    them a ray has a slope, or a multiplier, that is rounding."""
    fixed, cart, found = template.fixed, template.cart_rows, dict[str, Bound]()
    rows = template.contact_rows(contacts)
    slope = (cut.linear + cut.multipliers @ rows).ravel()
    largest = max(float(np.abs(cut.linear).max()), float((np.abs(cut.multipliers) @ np.abs(rows)).max()))
    for j in np.flatnonzero(np.abs(slope) > NEGLIGIBLE_MULTIPLIER_RATIO * largest):
        names, values = (fixed.lower_names, fixed.lower) if slope[j] > 0 else (fixed.upper_names, fixed.upper)
        if np.isfinite(values[j]):
            found[names[j]] = Bound(float(values[j]), _unit(np.eye(len(slope))[j], template.n))
    smallest = NEGLIGIBLE_MULTIPLIER_RATIO * float(np.abs(solution.multipliers).max())
    dual = solution.multipliers[len(solution.x) :][: len(fixed.limits) + len(cart.low)]
    lows = zip(fixed.low_names + cart.low_names, [*fixed.low_limits, *cart.low], strict=True)
    highs = zip(fixed.names + cart.high_names, [*fixed.limits, *cart.high], strict=True)
    units = [_unit(row, template.n) for row in fixed.rows] + list(cart.each_unit)
    for y, low, high, unit in zip(dual, lows, highs, units, strict=True):
        name, value = high if y > 0 else low
        if abs(y) > smallest and np.isfinite(value):
            found[name] = Bound(float(value), unit)
    cones = [(cone.name, _cone_bound(cone, template.n)) for cone in fixed.cones]
    cones += [(cone.name, Bound(0.0, "N")) for cone in cart.cones]
    pairs = zip(cones, solution.cone_multipliers, strict=True)
    found.update({name: bound for (name, bound), z in pairs if z[0] > smallest})
    return found


def _cone_bound(cone: Cone, n: int) -> Bound:
    """The largest norm of a cone with a fixed axis; 0 where that grows with the wrenches, as friction does."""
    is_fixed = not cone.rows[0].any()
    return Bound(float(cone.offset[0]), _unit(np.abs(cone.rows).sum(axis=0), n)) if is_fixed else Bound(0.0, "N")


def _unit(row: Array, n: int) -> str:
    """Unit of a row over all unknowns, of which the first n are the arms' wrenches."""
    parts = row[:n].reshape(-1, 6)
    units = [unit for unit, part in (("N", parts[:, :3]), ("N·m", parts[:, 3:])) if part.any()]
    return units[0] if len(units) == 1 else ""


def _words(bounds: Mapping[str, Bound], direction: Array, numbers: tuple[float, float]) -> str:
    name = in_words(direction)
    unit = " N" if not direction[2] else " N·m" if not direction[:2].any() else ""
    of_what = SINGLE_DIRECTIONS.get(name, f"{name}" if unit else f"{name} (fx, fy in N, tau in N·m)")
    parts = []
    for limit, bound in bounds.items():
        words = limit.rpartition(":")[2].split()  # an arm may be called "torque"
        number = bound.value if "rate" in words else abs(bound.value)  # about the last wrench, which has a sign
        of = "N·m" if "torque" in words else bound.unit  # of a joint, by all components
        parts.append(f"{limit} {number:.6g} {of}".strip() if words[-1] in ("lower", "upper") else limit)
    asked, most = (f"{round(number, 9) + 0.0:.6g}{unit}" for number in numbers)
    owners = {limit.rpartition(":")[0] for limit in bounds}  # "" of the cart
    subject = "it gives" if len(parts) == 1 or (len(owners) == 1 and owners != {""}) else "together they give"
    return f"{'; '.join(parts)}: {subject} at most {most} of {of_what}, {asked} is asked"
