"""The nearest to a wrench that can't be given, by compiled calls: `minimise ½ ‖t‖² + ½ PROXIMAL_WEIGHT ‖F - F'‖²`,
such that `Sᵀ sum G_i F_i + t = Sᵀ wrench_b` and F is within the limits. What bends limits that half-spaces stand for
may be added to the cost (`Bend`).

F' are the wrenches of the call before. So each program is strictly convex, and kernels of allocations take it; what is
missing, t, soon is that of `allocation/projection.py` (the proximal point method; Rockafellar, 1976).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..allocation.projection import projection_program
from ..plan import RELAXED, Plan
from ..quadratic_program import INFEASIBLE
from . import compiled_allocation
from .compiled_allocation import SOLVER, Point

PROXIMAL_WEIGHT, MAX_PROXIMAL_STEPS, CONVERGENCE_TOLERANCE = 1e-3, 20, 1e-9
"""Curvature about the wrenches before; most steps; and the change of what is missing, as a share, that ends them."""
SLACK_MARGIN_RATIO = 1e-7
"""Share of what is missing that is left out besides: rounding at the edge of what can be given is not to matter."""


NoAnswer = Literal["forbidden", "unproven"]
FORBIDDEN: Literal["forbidden"] = "forbidden"
"""No wrench keeps the limits, as is proven."""
UNPROVEN: Literal["unproven"] = "unproven"
"""No proof was found, of a nearest one or that there is none."""
Near = tuple[Plan, float] | NoAnswer
"""The plan of the nearest wrench, and how far that is from what was asked (N, N·m); or why there is none."""


class Bend(NamedTuple):
    """A curvature (6n, 6n) of the cost about wrenches (6n,)."""

    curvature: Array
    about: Array


class Nearest(NamedTuple):
    """Wrenches (6n,), what they miss of a planar wrench in {b} (k,), and multipliers of the cart's rows."""

    wrenches: Array
    missing: Array
    of_cart_rows: Array


def nearest(template: AllocationTemplate, points: Array, wrench: Point, bend: Bend | None) -> Nearest | NoAnswer:
    """For arms at points (n, 3)."""
    from ..kernels.allocation import allocate
    from ..kernels.loading import load, load_gradient, load_spans
    from ..kernels.workspace import Sizes, views

    n, k = template.n, template.basis_b.shape[1]
    program = template.program(template.contact_rows(points), np.zeros(k), template.cost(np.zeros(n)))
    program = projection_program(program, template.slack_map(False))
    pull, hessian = np.zeros(n + k), program.hessian + PROXIMAL_WEIGHT * np.diag(np.repeat([1.0, 0.0], [n, k]))
    if bend is not None:
        hessian[:n, :n] += bend.curvature
        pull[:n] = bend.curvature @ bend.about
    program = replace(program, hessian=hessian, gradient=-pull)
    floats, ints = Sizes(n + k, len(program.lower), k, free=k).allocate()
    workspace = views(floats, ints)
    workspace.basis[:] = template.basis_b
    load(workspace, program)
    load_spans(workspace, program.stacked[program.n :] != 0)
    found, before = workspace.claim.x, np.full(k, np.inf)
    for _ in range(MAX_PROXIMAL_STEPS):
        status = allocate(floats, ints, wrench, False)
        if status != compiled_allocation.OPTIMAL:
            return FORBIDDEN if status == compiled_allocation.INFEASIBLE else UNPROVEN
        missing = found[n:].copy()
        if np.abs(missing - before).max() <= CONVERGENCE_TOLERANCE * max(1.0, np.abs(missing).max()):
            break
        before = missing
        load_gradient(workspace, -pull - PROXIMAL_WEIGHT * np.append(found[:n], np.zeros(k)), 0.0)
    else:
        return UNPROVEN
    y, n_rows = workspace.claim.y, len(template.cart_rows.low)
    return Nearest(found[:n].copy(), (1.0 + SLACK_MARGIN_RATIO) * missing, y[len(y) - k - n_rows : len(y) - k].copy())


def left_open(near: Near, relax: float, explain: Callable[[], Plan], start: float) -> Plan:
    """The plan of what is near, relaxed, if it is no farther than that; else one that is infeasible. What `explain`
    says of it is found when it is asked for."""
    fields: dict[str, Any] = {"solver": SOLVER, "solve_time": time.perf_counter() - start}
    fields |= {"found_why": explain, "tell": lambda: explain().figures}
    if isinstance(near, str) or near[1] > relax:
        return Plan.of(fields | {"status": INFEASIBLE, "wrenches": {}, "contacts": {}, "yaws": {}})
    whole = vars(near[0]) | fields | {"status": RELAXED, "prove": lambda: explain().proof}
    del whole["message"]
    return Plan.of(whole)
