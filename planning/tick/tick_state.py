"""What `WrenchPlanner` keeps between ticks: the terms that hold, the last plan, and what is made for both."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Self

from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.shallow_copy import shallow_copy

from ..contacts.contact_cases import CaseSolver
from ..contacts.switching_cost import SwitchingCost
from ..plan import INVALID_INPUT
from ..solvers import QuadraticSolver
from .answers import Answers
from .compiled_planning import CompiledPlanning
from .estimate_inputs import check_estimate
from .given_contacts import GivenContacts
from .last_plan import LastPlan
from .plan_inputs import RefusedError, read_arms
from .program_at_contacts import ProgramAtContacts
from .terms import Settings, Terms, scaled_into

if TYPE_CHECKING:
    from cartgrasp.motion import Estimate


# Many methods: one for each kind of news that a planner gets between two ticks; it alone is changed by them.
class TickState:
    """What is kept for `arms`, or for those of them that hold now; `is_warm` says whether kernels may be used."""

    def __init__(self, settings: Settings, arms: Sequence[Arm]) -> None:
        self._settings, self.is_warm, self.last, self.before = settings, False, LastPlan.none(0), LastPlan.none(0)
        self.newest_estimate = -math.inf
        self.stop_share = 1.0  # of the margins, with which the last tick without a plan stopped the cart
        self.compiled: CompiledPlanning | None = None
        self._begin(Terms(settings, arms), ())
        self.names = self.terms.base.names
        self.reset()

    def reset(self) -> None:
        """Forgets the last wrench, contacts and estimate's time."""
        self.newest_estimate = -math.inf
        if self.compiled is not None:
            self.compiled.forget()
        self.go_back_to(LastPlan.none(len(self.terms.sets)))

    def start_from(self, wrenches: Mapping[str, ArrayLike], contacts: Mapping[str, ArrayLike]) -> None:
        self.last = self.last.started(self.terms.base.names, wrenches, contacts)
        self.look_back_at(scaled_into(self.terms.base.limits, self.last.wrenches))

    def warm_up(self, calls: Callable[[], object]) -> None:
        """Kernels from now on, which `calls` call; what is remembered stays."""
        self.is_warm, last, newest = True, self.last, self.newest_estimate
        self.reset()
        self.begin_terms()
        calls()
        self.reset()
        self.newest_estimate = newest
        self.go_back_to(last)

    def as_it_is(self) -> Self:
        """One that stays as this is now, without kernels."""
        other = shallow_copy(self)
        other.terms, other.compiled = shallow_copy(self.terms), None
        return other

    def renew_solvers(self) -> None:
        """Workspaces that no other solves with."""
        terms, solver = self.terms, self._settings.solver
        self.solver, self._cases = QuadraticSolver(name=solver), CaseSolver(terms.template, solver)
        self.answers, self.program = Answers(terms, self._settings.relax, solver), ProgramAtContacts(terms)

    @property
    def cases(self) -> CaseSolver:
        """For what holds now."""
        self._cases.template = self.terms.template
        return self._cases

    # --- what a tick says ---------------------------------------------------------------------------------

    def take_estimate(self, estimate: Estimate) -> None:
        newest, before = check_estimate(estimate, self.newest_estimate), self.terms.base.cart_rows
        self.terms.take_estimate(estimate)
        if not self.terms.base.cart_rows.is_like(before):  # margins came, or went
            self._compile()
        self.newest_estimate = newest  # one that is refused makes no later one stale

    def go_back_to(self, last: LastPlan) -> None:
        """As if what was remembered since had not been."""
        self.last = last
        self.look_back_at(last.wrenches)

    def take_arms(self, arms: Sequence[Arm]) -> None:
        new, before = read_arms(arms, self.names), self.terms
        if new.keys() == before.sets.keys():
            if before.take_arms(new):
                self.begin_terms()
            return
        try:
            terms = Terms(self._settings, [new[name] for name in self.names if name in new])
        except UsageError as error:
            raise RefusedError(INVALID_INPUT, str(error)) from error
        if before.estimate is not None:
            terms.take_estimate(before.estimate)
        self._begin(terms, before.base.names)

    def take_postures(self, contacts: Mapping[str, ArrayLike] | None) -> None:
        if self.terms.has_postures and self.terms.take_postures(contacts):
            self.begin_terms()

    def remember(self, wrenches: Array, contacts: Array) -> None:
        """What was given last (6n,), at contacts (n, 3)."""
        self.before, self.last = self.last, LastPlan(wrenches, contacts, self.last.choice)
        if self.terms.looks_back:
            self.look_back_at(wrenches)

    # --- what is made for it ------------------------------------------------------------------------------

    def _begin(self, terms: Terms, before: Sequence[str]) -> None:
        """What is made for the arms of `terms`; of those `before` what was last is kept."""
        names, settings = terms.base.names, self._settings
        costs = settings.costs_of(names) if before else settings.switching_cost  # which are checked at first
        self.terms, self.switching = terms, SwitchingCost(costs, names)
        self.last = self.last.among(before, names)
        self.given = GivenContacts(terms)
        self.renew_solvers()
        self.compiled, self.cost = None, terms.base.cost(self.last.wrenches)
        self.begin_terms()

    def begin_terms(self) -> None:
        """Drops what was made for other arms, and scales what is held into the limits of these."""
        if not self.given.fits:
            self.given, self.last = GivenContacts(self.terms), self.last._replace(choice=None)
        self.compiled = None if self.compiled is None else self.compiled.renewed()
        if self.compiled is None:
            self._compile()
        self.look_back_at(scaled_into(self.terms.base.limits, self.last.wrenches))

    def _compile(self) -> None:
        """Where it is warm, no other solver is asked for, and what is compiled covers the programs."""
        wanted = self.is_warm and self._settings.solver is None
        self.compiled = CompiledPlanning.of(self.terms, self.cost) if wanted else None

    def look_back_at(self, wrenches: Array) -> None:
        self.last = self.last._replace(wrenches=wrenches)
        self.cost = self.terms.base.cost(wrenches)
        self.terms.take_last(wrenches)
