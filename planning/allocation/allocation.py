"""A desired planar wrench over the arms at given contacts: the program, and its certified solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import straight_force
from cartgrasp.frames import Array

from ..limits import CartLimit
from ..objectives import Lexicographic, Objective
from ..quadratic_program import INFEASIBLE, NUMERICAL, OPTIMAL, QPSolution, QuadraticProgram
from ..solvers import QuadraticSolver, solve_with_clarabel
from .allocation_template import AllocationTemplate
from .contradiction import contradiction
from .infeasibility import Certificate, certify, nearest_plan
from .projection import project
from .second_stage import second_stage

if TYPE_CHECKING:
    from cartgrasp.model import CartModel


@dataclass(frozen=True, eq=False)
class Allocation:
    """Wrenches (6,) in {a} by arm, with their proof; when `infeasible`, the proof that there are none."""

    status: str
    wrenches: Mapping[str, Array]
    effort: float
    active: tuple[str, ...]
    solution: QPSolution
    certificate: Certificate | None = None


def build_allocation(
    cart: CartModel,
    arms: Sequence[Arm],
    contacts: Mapping[str, ArrayLike],
    wrench_b: ArrayLike,
    objective: Objective | None = None,
    cart_limits: Sequence[CartLimit] = (),
) -> QuadraticProgram:
    """minimise the objective over F (6n,) such that `Sᵀ sum G_i F_i = Sᵀ wrench_b` and every limit holds."""
    template, points = template_at(cart, arms, contacts, objective, cart_limits)
    return _posed(template, points, wrench_b, _straight(template, cart, wrench_b))


def allocate(
    cart: CartModel,
    arms: Sequence[Arm],
    contacts: Mapping[str, ArrayLike],
    wrench_b: ArrayLike,
    objective: Objective | None = None,
    cart_limits: Sequence[CartLimit] = (),
) -> Allocation:
    """`build_allocation`, solved and proven."""
    template, points = template_at(cart, arms, contacts, objective, cart_limits)
    straight = _straight(template, cart, wrench_b)
    program = _posed(template, points, wrench_b, straight)
    allocation = conclude(template, points, program, QuadraticSolver().solve(program))
    if allocation.status == OPTIMAL and isinstance(objective, Lexicographic):
        second = template.second_cost(np.zeros(template.n), straight)
        return _solved(template, *second_stage(QuadraticSolver(), program, allocation.solution, second))
    return allocation


def _posed(template: AllocationTemplate, points: Array, wrench_b: ArrayLike, straight: float) -> QuadraticProgram:
    target = template.basis_b.T @ np.asarray(wrench_b, dtype=float)
    return template.program(template.contact_rows(points), target, template.cost(np.zeros(template.n), straight))


def conclude(
    template: AllocationTemplate, contacts: Array, program: QuadraticProgram, solution: QPSolution
) -> Allocation:
    """A solution as an allocation; a failure is explained, and called infeasible only with a certificate."""
    if solution.status == OPTIMAL:
        return _solved(template, program, solution)
    target = program.equality[1]
    projection = project(QuadraticSolver(always_feasible=True), program, template.slack_map(False))
    if projection.solution.status != OPTIMAL:
        certificate = contradiction(template, program, target)
        if certificate is not None:
            return Allocation(INFEASIBLE, {}, np.nan, (), solution, certificate)
    elif not projection.is_feasible(target):
        certificate = certify(template, contacts, projection, target)
        if certificate is not None:
            nearest = nearest_plan(template, contacts, projection, program)
            certificate = replace(certificate, nearest=nearest)
            return Allocation(INFEASIBLE, {}, np.nan, (), solution, certificate)
    second = solve_with_clarabel(program)
    if second.status != OPTIMAL and projection.is_feasible(target):
        second = solve_with_clarabel(program.with_equality_value(target - projection.slack))
    if second.status == OPTIMAL:
        return _solved(template, program, second)
    return Allocation(NUMERICAL, {}, np.nan, (), second)


def template_at(
    cart: CartModel,
    arms: Sequence[Arm],
    contacts: Mapping[str, ArrayLike],
    objective: Objective | None = None,
    cart_limits: Sequence[CartLimit] = (),
) -> tuple[AllocationTemplate, Array]:
    """The arms in their postures at contacts, and these (n, 3) in the order of the arms."""
    template = AllocationTemplate.of(cart, arms, objective, cart_limits)
    points = _contact_array(template, contacts)
    there = tuple(arm.at(point) for arm, point in zip(template.arms, points, strict=True))
    if all(arm is before for arm, before in zip(there, template.arms, strict=True)):
        return template, points
    return AllocationTemplate.of(cart, there, objective, cart_limits), points


def _contact_array(template: AllocationTemplate, contacts: Mapping[str, ArrayLike]) -> Array:
    if set(contacts) != set(template.names):
        raise UsageError(f"contacts of {sorted(contacts)} are given, arms are {sorted(template.names)}")
    points = np.array([np.asarray(contacts[name], dtype=float) for name in template.names])
    if points.shape != (len(template.arms), 3) or not np.isfinite(points).all():
        raise UsageError("contacts: each must be three finite numbers (x, y, z in {b}, m)")
    return points


def _straight(template: AllocationTemplate, cart: CartModel, wrench_b: ArrayLike) -> float:
    """N, at rest; zero where no cost asks for it."""
    if not template.looks_at_wheels:
        return 0.0
    slope, besides = straight_force(cart)
    return float(slope @ np.asarray(wrench_b, dtype=float)) + besides


def _solved(template: AllocationTemplate, program: QuadraticProgram, solution: QPSolution) -> Allocation:
    wrenches = dict(zip(template.names, solution.x[: template.n].reshape(-1, 6), strict=True))
    return Allocation(OPTIMAL, wrenches, template.effort(solution.x[: template.n]), program.active(solution), solution)
