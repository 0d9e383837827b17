"""The planner's program from tick to tick."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

from ..objectives import Cost
from ..quadratic_program import QuadraticProgram
from .terms import Terms


class ProgramAtContacts:
    """Where contacts are as at the last call, only the equality's value is new, and what looks back."""

    def __init__(self, terms: Terms) -> None:
        self._terms = terms
        self.drop()

    def drop(self) -> None:
        """For terms that have changed."""
        self._program: QuadraticProgram | None = None
        self._points = np.zeros((0, 3))

    def at(self, points: Array, target: Array, cost: Cost) -> QuadraticProgram:
        """At contacts (n, 3), for an effective wrench (k,)."""
        base = self._terms.base
        same = points is self._points or np.array_equal(points, self._points)
        if self._program is None or not same:
            self._program, self._points = base.program(base.contact_rows(points), target, cost), points
        program = self._program.with_equality_value(target)
        if self._terms.rate is not None:
            program = program.with_bounds(self._terms.template.limits)
        if base.objective.looks_back or base.looks_at_wheels:
            program = program.with_gradient(cost.gradient, cost.constant)
        return program
