"""An allocation at given contacts as one compiled call: assembly, solution and proof (kernels/allocation.py).

What is compiled covers strictly convex costs and linear limits over the wrenches alone; programs with cones, weights
of zero or other unknowns take the general road, and so does a call whose answer isn't proven.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Self

import numpy as np

from cartgrasp.frames import Array

from .allocation_template import AllocationTemplate
from .objectives import Cost, Lexicographic

if TYPE_CHECKING:
    from .kernels.working_set import Ints
    from .kernels.workspace import Workspace

Point = tuple[float, float, float]
SOLVER = "dual active set"


Tables = tuple[Array, "Ints", Array, Array, Array, Array, Array]
Progress = tuple[Array, "Ints"]


class CompiledAllocation:
    """One workspace, kept warm. After `solve` has returned True, `answer` and `active` are its."""

    def __init__(self, template: AllocationTemplate, cost: Cost) -> None:
        from .kernels.allocation import allocate
        from .kernels.choice import search
        from .kernels.loading import load, load_gradient
        from .kernels.workspace import Sizes, views

        target, n_arms = np.zeros(template.basis_b.shape[1]), len(template.arms)
        rows = template.contact_rows(np.zeros((n_arms, 3)))
        program, moving = template.program(rows, target, cost), rows.shape[-2]
        sizes = Sizes(program.n, len(program.upper), program.n_equalities, n_arms, moving, len(target))
        self._search = search
        self._call: Callable[[Array, Ints, Point, bool], int] = allocate
        self._floats, self._ints = sizes.allocate()
        self._workspace: Workspace = views(self._floats, self._ints)
        self._answer = self._floats[len(self._floats) - program.n - len(program.upper) - len(self._workspace.found) :]
        self._active = self._workspace.active
        self._lower_names, self._upper_names = program.lower_names, program.upper_names
        self._load_gradient = load_gradient
        self._template, self.cost = template, cost
        self._points: Array | None = None
        self._load_contact_rows(template)
        pattern = program.stacked[program.n :].copy()
        pattern[len(pattern) - moving :] = 1.0 if len(template.cart_rows.low) else np.abs(self._workspace.affine).sum(0)
        load(self._workspace, program, pattern)
        self._workspace.basis[:], self._workspace.weights[:] = template.basis_b, template.effort_weights

    @classmethod
    def of(cls, template: AllocationTemplate, cost: Cost) -> Self | None:
        """None where what is compiled doesn't cover the programs."""
        from .kernels.loading import is_strictly_convex

        covered = not (template.fixed.cones or template.cart_rows.cones) and len(template.hessian) == template.n
        covered &= not isinstance(template.objective, Lexicographic)
        return cls(template, cost) if covered and is_strictly_convex(template.hessian) else None

    def take(self, template: AllocationTemplate, cost: Cost) -> None:
        """What is new since the last call: numbers of the cart's limits, bounds, or what the cost looks back at."""
        if template is not self._template:
            self._take_limits(template)
        if cost is not self.cost:
            self.cost = cost
            self._load_gradient(self._workspace, cost.gradient, cost.constant)

    def _take_limits(self, template: AllocationTemplate) -> None:
        if template.cart_rows is not self._template.cart_rows:
            self._load_contact_rows(template)
        problem, bounds = self._workspace.problem, template.limits
        problem.limits[:, : template.n] = bounds.lower, bounds.upper
        self._workspace.held.size[0] = 0
        self._lower_names = bounds.lower_names + self._lower_names[template.n :]
        self._upper_names = bounds.upper_names + self._upper_names[template.n :]
        self._template = template

    def _load_contact_rows(self, template: AllocationTemplate) -> None:
        """The rows that depend on contacts, with all arms at the origin, and their slopes along x, y and z."""
        affine = self._workspace.affine
        affine[:] = template.affine_rows().transpose(0, 2, 1, 3).reshape(affine.shape)
        limits, first = self._workspace.problem.limits, len(affine[0])
        limits[:, limits.shape[1] - first :] = template.contact_limits(np.zeros(template.basis_b.shape[1]))
        self._points = None

    def solve(self, wrench: Point, points: Array) -> bool:
        """For a planar wrench in {b}, with the arms at `points` (n, 3); True if there is a proven optimum. Points
        that are the same object as at the last call are not handed over again."""
        moved = points is not self._points
        if moved:
            self._workspace.points[:] = points
        solved = self._call(self._floats, self._ints, wrench, moved) == 0
        self._points = points if solved else None
        return solved

    def search(self, wrench: Point, tables: Tables, progress: Progress, limit: tuple[int, float]) -> bool:
        """See kernels/choice.py; `limit` is of programs and of the gap. False if it gave up."""
        self._points = None
        return self._search(self._floats, self._ints, wrench, tables, progress, *limit) == 0

    def answer(self) -> Array:
        """A copy of what was found: wrenches (6n,), multipliers as of a `QPSolution`, residuals and the effort."""
        return self._answer.copy()

    @property
    def active(self) -> tuple[str, ...]:
        """As `QuadraticProgram.active`."""
        active = self._active
        count = active.item(0)
        if not count:
            return ()
        lower, upper = self._lower_names, self._upper_names
        return tuple([upper[i - 1] if i > 0 else lower[-i - 1] for i in active[1 : count + 1].tolist()])
