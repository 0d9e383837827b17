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
from .objectives import Cost
from .quadratic_program import QuadraticProgram

if TYPE_CHECKING:
    from .kernels.working_set import Ints
    from .kernels.workspace import Workspace

Point = tuple[float, float, float]
SOLVER = "dual active set"


Tables = tuple[Array, "Ints", Array, Array, Array, Array]
Progress = tuple[Array, "Ints"]


class CompiledAllocation:
    """One workspace, kept warm. After `solve` has returned True the other properties are of its answer."""

    def __init__(self, template: AllocationTemplate, cost: Cost) -> None:
        from .kernels.allocation import allocate
        from .kernels.choice import search
        from .kernels.loading import load, load_gradient
        from .kernels.workspace import Sizes, views

        programs = _programs(template, cost)
        program, n_arms, n_free = programs[0], len(template.arms), template.basis_b.shape[1]
        moving = template.contact_rows(np.zeros((n_arms, 3))).shape[-2]
        sizes = Sizes(program.n, len(program.upper), program.n_equalities, n_arms, moving, n_free)
        self._search = search
        self._call: Callable[[Array, Ints, Point, bool], int] = allocate
        self._floats, self._ints = sizes.allocate()
        self._workspace: Workspace = views(self._floats, self._ints)
        self._x, self._found, self._active = self._workspace.claim.x, self._workspace.found, self._workspace.active
        self._lower_names, self._upper_names = program.lower_names, program.upper_names
        self._load_gradient = load_gradient
        self._points: Array | None = None
        pattern, affine = program.stacked[program.n :].copy(), self._workspace.affine
        last = np.array([p.rows[len(p.rows) - moving :] for p in programs])
        affine[0], affine[1:] = last[0], last[1:] - last[0]
        pattern[len(pattern) - moving :] = np.abs(affine).sum(axis=0)
        load(self._workspace, program, pattern)
        self._workspace.basis[:], self._workspace.weights[:] = template.basis_b, template.effort_weights

    @classmethod
    def of(cls, template: AllocationTemplate, cost: Cost) -> Self | None:
        """None where what is compiled doesn't cover the programs."""
        from .kernels.loading import is_strictly_convex

        covered = not template.limits.cones and len(template.hessian) == template.n
        return cls(template, cost) if covered and is_strictly_convex(template.hessian) else None

    def set_gradient(self, cost: Cost) -> None:
        self._load_gradient(self._workspace, cost.gradient, cost.constant)

    def solve(self, wrench: Point, points: Array) -> bool:
        """For a planar wrench in {b}, with the arms at `points` (n, 3); True if there is a proven optimum. Points
        that are the same object as at the last call are not handed over again."""
        moved = points is not self._points
        if moved:
            self._workspace.points[:] = points
        solved = self._call(self._floats, self._ints, wrench, moved) == 0
        self._points = points if solved else None
        return solved

    def search(self, wrench: Point, tables: Tables, progress: Progress, most: int) -> bool:
        """See kernels/choice.py; False if it gave up."""
        self._points = None
        return self._search(self._floats, self._ints, wrench, tables, progress, most) == 0

    @property
    def wrenches(self) -> Array:
        """A copy, (6n,)."""
        return self._x.copy()

    @property
    def numbers(self) -> list[float]:
        """Residuals in the order of `Residuals`, and the effort."""
        numbers: list[float] = self._found.tolist()
        return numbers

    @property
    def active(self) -> tuple[str, ...]:
        """As `QuadraticProgram.active`."""
        active = self._active
        count = active.item(0)
        if not count:
            return ()
        lower, upper = self._lower_names, self._upper_names
        return tuple([upper[i - 1] if i > 0 else lower[-i - 1] for i in active[1 : count + 1].tolist()])


def _programs(template: AllocationTemplate, cost: Cost) -> list[QuadraticProgram]:
    """With all arms at the origin, and at one unit along x, y and z."""
    n_arms, target = len(template.arms), np.zeros(template.basis_b.shape[1])
    places = np.concatenate([np.zeros((1, 3)), np.eye(3)])[:, None].repeat(n_arms, axis=1)
    return [template.program(template.contact_rows(points), target, cost) for points in places]
