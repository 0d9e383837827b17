"""What the next tick is to solve, in cvxpy.

Variables are the arms' wrenches (6,) in {a}, by the arms' names, and `own` for what an objective adds to them. The
parameter `wrench` is what the cart shall get: another value makes it another tick's problem (with `LeastSideForce` the
cost changes, too). Constraints tell by a label whose they are. Of an order of two objectives it is the first.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.errors import UsageError

from .last_plan import LastPlan
from .plan_inputs import RefusedError, read_contacts, read_wrench
from .program_at_contacts import ProgramAtContacts
from .terms import Terms

if TYPE_CHECKING:
    import cvxpy


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
