"""An allocation at given contacts as one compiled call: assembly, solution and proof (kernels/allocation.py).

What is compiled covers strictly convex costs and linear limits over the wrenches alone; programs with cones, weights
of zero or other unknowns take the general road, and so does a call whose answer isn't proven.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Self

import numpy as np

from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..objectives import Cost, Lexicographic
from ..quadratic_program import LimitNames

if TYPE_CHECKING:
    from ..kernels.working_set import Ints
    from ..kernels.workspace import Workspace

Point = tuple[float, float, float]
SOLVER = "dual active set"
OPTIMAL, INFEASIBLE = range(2)
"""As `kernels.dual_active_set` has them."""


Tables = tuple[Array, "Ints", Array, Array, Array, Array, Array]
Progress = tuple[Array, "Ints"]


class CompiledAllocation:
    """One workspace, kept warm. After `solve` has returned True, `answer` is its; after False, `is_infeasible` says
    whether that is proven. `names` are of the limits, but for the wrench asked for."""

    cost: Cost
    names: LimitNames
    _points: Array | None
    is_infeasible: bool = False

    def __init__(self, template: AllocationTemplate, cost: Cost) -> None:
        from ..kernels import loading
        from ..kernels.allocation import allocate
        from ..kernels.choice import search
        from ..kernels.workspace import Sizes, views

        self._loading, self._search = loading, search
        self._call: Callable[[Array, Ints, Point, bool], int] = allocate
        self._sizes = sizes = _sizes(template)
        self._floats, self._ints = Sizes(*sizes).allocate()
        self._workspace: Workspace = views(self._floats, self._ints)
        self._answer = self._floats[len(self._floats) - sizes[0] - sizes[1] - len(self._workspace.found) :]
        self._template, self._points = template, None
        self._entries = np.zeros((0, 0), dtype=bool)
        self._load_contact_rows(template)
        self._load(template, cost)

    @classmethod
    def of(cls, template: AllocationTemplate, cost: Cost) -> Self | None:
        """None where what is compiled doesn't cover the programs."""
        from ..kernels.loading import is_strictly_convex

        return cls(template, cost) if _is_covered(template) and is_strictly_convex(template.hessian) else None

    def fits(self, template: AllocationTemplate) -> bool:
        """Whether it may `take` this template: new arms may have more limits, or none that are covered."""
        if not _is_covered(template) or _sizes(template) != self._sizes:
            return False
        hessian = template.hessian
        return np.array_equal(hessian, self._workspace.claim.hessian) or self._loading.is_strictly_convex(hessian)

    def take(self, template: AllocationTemplate, cost: Cost) -> None:
        """What is new since the last call: arms, numbers of the cart's limits, bounds, or what the cost looks back
        at."""
        if template.arms is not self._template.arms:
            self._load(template, cost)
        if template is not self._template:
            self._take_limits(template)
        if cost is not self.cost:
            self.cost = cost
            self._loading.load_gradient(self._workspace, cost.gradient, cost.constant)

    def _load(self, template: AllocationTemplate, cost: Cost) -> None:
        workspace, program, before = self._workspace, template.at_points, self._template
        curved = self._loading.load(workspace, program)
        self._loading.load_gradient(workspace, cost.gradient, cost.constant)
        workspace.basis[:] = template.basis_b
        turned = template.yaws is not before.yaws
        if turned or template.cart_rows is not before.cart_rows:
            self._load_contact_rows(template)
        self._load_contact_limits(template)
        entries = template.fixed.rows != 0
        if turned or curved or not np.array_equal(entries, self._entries):
            pattern, moving = workspace.problem.rows != 0, workspace.affine.shape[1]
            pattern[len(pattern) - moving :] = len(template.cart_rows.low) > 0 or workspace.affine.any(axis=0)
            self._loading.load_spans(workspace, pattern)
            self._entries = entries
        stop = len(program.lower) - program.n_equalities
        self.names = program.lower_names[:stop], program.upper_names[:stop]
        self._template, self.cost, self._points = template, cost, None

    def _take_limits(self, template: AllocationTemplate) -> None:
        if template.cart_rows is not self._template.cart_rows:
            self._load_contact_rows(template)
            self._load_contact_limits(template)
            self._points = None
        if template.limits is not self._template.limits:
            bounds = template.limits
            self._workspace.problem.limits[:, : template.n] = bounds.lower, bounds.upper
            lower, upper = (names[template.n :] for names in self.names)
            self.names = bounds.lower_names + lower, bounds.upper_names + upper
        self._workspace.held.size[0] = 0
        self._template = template

    def _load_contact_rows(self, template: AllocationTemplate) -> None:
        """The rows that depend on contacts, with all arms at the origin, and their slopes along x, y and z."""
        rows = template.affine_rows().transpose(0, 2, 1, 3)
        self._workspace.affine.reshape(rows.shape)[:] = rows

    def _load_contact_limits(self, template: AllocationTemplate) -> None:
        """But for the wrench asked for."""
        limits, rows = self._workspace.problem.limits, template.cart_rows
        stop = limits.shape[1] - template.basis_b.shape[1]
        limits[0, stop - len(rows.low) : stop], limits[1, stop - len(rows.low) : stop] = rows.low, rows.high

    def solve(self, wrench: Point, points: Array) -> bool:
        """For a planar wrench in {b}, with the arms at `points` (n, 3); True if there is a proven optimum. Points
        that are the same object as at the last call are not handed over again."""
        moved = points is not self._points
        if moved:
            self._workspace.points[:] = points
        status = self._call(self._floats, self._ints, wrench, moved)
        self._points, self.is_infeasible = points if status == OPTIMAL else None, status == INFEASIBLE
        return status == OPTIMAL

    def search(self, wrench: Point, tables: Tables, progress: Progress, limit: tuple[int, float]) -> bool:
        """See kernels/choice.py; `limit` is of programs and of the gap. False if it gave up."""
        self._points = None
        return self._search(self._floats, self._ints, wrench, tables, progress, *limit) == 0

    @property
    def blocks(self) -> tuple[Array, Ints]:
        """The workspace, for kernels that call `allocate`."""
        return self._floats, self._ints

    def answer(self) -> Array:
        """A copy of what was found: wrenches (6n,), multipliers as of a `QPSolution`, residuals."""
        return self._answer.copy()


def _is_covered(template: AllocationTemplate) -> bool:
    has_cones = template.fixed.cones or template.cart_rows.cone_names
    is_plain = len(template.hessian) == template.n and not isinstance(template.objective, Lexicographic)
    return is_plain and not has_cones


def _sizes(template: AllocationTemplate) -> tuple[int, int, int, int, int, int]:
    """As `kernels.workspace.Sizes` has them."""
    k = template.basis_b.shape[1]
    moving = len(template.cart_rows.low) + k
    return template.n, template.n + len(template.fixed.limits) + moving, k, len(template.arms), moving, k
