"""Limits that no wrench keeps, whatever is asked: the cart's, with the arms' held.

A cart that takes a bend too fast skids whatever the hands do. The least by which the cart's limits must be missed,
and its proof, come from a projection as well: what is asked is free there, and the contact rows have a slack.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array

from ..quadratic_program import OPTIMAL, QuadraticProgram
from ..solvers import QuadraticSolver
from .allocation_template import AllocationTemplate
from .duality import infeasible_by
from .infeasibility import Certificate
from .projection import moved, project, projection_program

ROW_TOLERANCE = 1e-12  # of the largest limit


def contradiction(
    template: AllocationTemplate, program: QuadraticProgram, target: Array, is_range: bool = False
) -> Certificate | None:
    """The proof for an allocation's program for `target` (k,), with the amounts by which the cart's limits are
    missed; None if it doesn't verify. Over a range of contacts it may be that none has its vertices the right way
    round."""
    c = len(template.cart_rows.low)
    if c == 0 and not is_range:
        return None  # what the arms state holds the last wrench
    slack_map = template.slack_map(is_range)
    from_zero = moved(projection_program(program, slack_map), slack_map, -target)
    free = replace(from_zero, n_equalities=0)
    missing = np.eye(len(slack_map))
    for cone in template.cart_rows.cones:
        missing[cone.first + 1 : cone.own.stop] = 0.0
    projection = project(QuadraticSolver(always_feasible=True), free, missing)
    if projection.solution.status != OPTIMAL or projection.distance == 0.0:
        return None
    least = infeasible_by(free, projection.normal_solution, projection.normal)
    limits = np.abs([template.cart_rows.low, template.cart_rows.high])
    if least <= ROW_TOLERANCE * max(1.0, float(limits[np.isfinite(limits)].max(initial=0.0))):
        return None
    rows, slack = template.cart_rows, projection.slack[:c]
    sides = zip(slack.tolist(), rows.low_names, rows.high_names, rows.each_unit, strict=True)
    largest = float(np.abs(slack).max(initial=0.0))
    missed = {low if t > 0 else high: (abs(t), unit) for t, low, high, unit in sides if abs(t) > 1e-7 * largest}
    parts = "; ".join(f"{name} by {amount:.6g} {unit}" for name, (amount, unit) in missed.items())
    amounts = {name: amount for name, (amount, _) in missed.items()}
    return Certificate(f"{parts}: missed at least that much, whatever the arms give", least, 0.0, (), amounts)
