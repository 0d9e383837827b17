"""The planner's program from tick to tick, and the next one in cvxpy.

Variables of that are the arms' wrenches (6,) in {a}, by the arms' names, and `own` for what an objective adds to them.
The parameter `wrench` is what the cart shall get: another value makes it another tick's problem (with `LeastSideForce`
the cost changes, too). Constraints tell by a label whose they are. Of an order of two objectives it is the first.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..objectives import Cost
from ..quadratic_program import QuadraticProgram
from .last_plan import LastPlan
from .plan_inputs import RefusedError, read_contacts, read_wrench
from .terms import Terms

if TYPE_CHECKING:
    import cvxpy


class ProgramAtContacts:
    """Where contacts and what holds there are as at the last call, only the equality's value is new, and what looks
    back."""

    def __init__(self, terms: Terms) -> None:
        self._terms = terms
        self._last: tuple[AllocationTemplate, Array, QuadraticProgram] | None = None

    def at(self, points: Array, target: Array, cost: Cost) -> QuadraticProgram:
        """At contacts (n, 3), for an effective wrench (k,)."""
        base, last = self._terms.base, self._last
        if last is None or base is not last[0] or not (points is last[1] or np.array_equal(points, last[1])):
            last = self._last = base, points, base.program(base.contact_rows(points), target, cost)
        program = last[2].with_equality_value(target)
        if self._terms.rate is not None:
            limits = self._terms.template.limits
            program = program.with_bounds(limits.lower, limits.upper, (limits.lower_names, limits.upper_names))
        if base.objective.looks_back or base.looks_at_wheels:
            program = program.with_gradient(cost.gradient, cost.constant)
        return program


def next_problem(terms: Terms, last: LastPlan, wrench: Any, contacts: Mapping[str, ArrayLike]) -> cvxpy.Problem:
    """For a wrench (3,) on the cart, at contacts (3,) by arm; arms left out hold where they held, or first may."""
    import cvxpy

    from ..solvers.cvxpy_problem import pose

    base = terms.base
    try:
        asked, given = read_wrench(wrench), read_contacts(contacts, base.names)
    except RefusedError as refused:
        raise UsageError(str(refused)) from refused
    places = zip(base.names, last.contacts_or(terms.first), strict=True)
    points = np.array([given.get(name, place) for name, place in places])
    to_effective = base.basis_b.T
    rest = terms.rest_of(asked)
    program = ProgramAtContacts(terms).at(points, to_effective @ rest, terms.cost(last.wrenches, asked))
    parameter = cvxpy.Parameter(3, name="wrench", value=np.array(asked))
    return pose(program, base.names, to_effective @ (parameter - np.subtract(asked, rest))).problem
