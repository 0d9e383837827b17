"""`WrenchPlanner`: what a controller calls at its rate; it checks, chooses contacts, allocates, and proves."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.checks import LARGEST_FLOAT, brief, check_kind, listed, number, positive
from cartgrasp.contacts import ContactWrenches
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.shallow import shallow

from .allocation.contradiction import contradiction
from .contacts.contact_bounds import Candidates
from .contacts.contact_cases import CaseSolver, Question
from .contacts.contact_choice import Choice, ContactSearch, SearchLimit
from .contacts.contact_regions import DISTANCE_TOLERANCE
from .contacts.switching_cost import SwitchingCost
from .limits import CartLimit
from .limits.robust import RobustLimits
from .objectives import Objective
from .plan import INVALID_INPUT, TIMEOUT, Plan
from .quadratic_program import INFEASIBLE, NUMERICAL
from .solvers import QuadraticSolver, solve_with_clarabel
from .tick.answers import Answers, Solved, proof_of
from .tick.compiled_allocation import SOLVER, Point
from .tick.compiled_nearest import FORBIDDEN, UNPROVEN, Near, left_open
from .tick.compiled_planning import CompiledPlanning
from .tick.estimate_inputs import check_estimate
from .tick.given_contacts import GivenContacts
from .tick.last_plan import LastPlan
from .tick.next_problem import next_problem
from .tick.plan_inputs import RefusedError, read_arms, read_wrench
from .tick.program_at_contacts import ProgramAtContacts
from .tick.refusals import at_nearest, certified, out_of_reach, refusal, too_near, undecided, unproven
from .tick.remedy import find_remedy, with_remedy
from .tick.terms import Terms, scaled_into

if TYPE_CHECKING:
    import cvxpy

    from cartgrasp.model import CartModel
    from cartgrasp.motion import Estimate

PERIOD, LONGEST_PERIOD, HOLD_TIME = 1e-3, 0.5, 0.1  # s: between calls of plan_or_hold; with which a held wrench decays
DEFAULT_SEARCH = SearchLimit()
NOWHERE: Mapping[str, ArrayLike] = {}


class WrenchPlanner:
    """Spreads a planar wrench over the arms of one cart, within every limit, with a proof.

    It remembers its last wrench and contacts: to hold them, to start the next choice of contacts from, for
    `Smoothness`, and for rates of change (from zero at first).

    Args:
        cart: What is pushed.
        arms: What holds it, each arm with its limits and places to hold.
        objective: What is least: `WeightedWrench()`, by the arms' own weights, unless given.
        cart_limits: Limits of the hands together: `Skid`, `TipOver`, `SideForce`, `InternalForce`.
        confidence: The probability (0.5 to below 1) with which all `cart_limits` hold, by the covariance of the
            estimate given last (robust.py). None: they hold for the cart as it is believed to be.
        min_hand_distance: m, between any two hands.
        relax: Where a wrench can't be given, the nearest is planned (`relaxed`) if it misses by at most this: N and
            N·m side by side, in effective rows; `inf` for any.
        switching_cost: What an arm pays that moves from where the last usable plan held, in the objective's unit (N² as
            a rule); one for every arm, or by arm (switching_cost.py).
        search_limit: When a choice among contacts ends before its optimum is proven: by programs solved, s, or gap.
        solver: Of programs, by any name that qpsolvers has installed ("osqp", "clarabel", …), with the same proof and
            accuracy, in the place of the compiled one, which is 30 to 170 times as fast.
        period: s between calls: a held wrench decays by it, and rates of change count by it.

    Raises:
        UsageError: An argument is of the wrong kind or out of bounds, or a cart limit needs `wheels` or `com_height`.

    Example:
        >>> import cartgrasp as cg
        >>> from planning import WrenchPlanner
        >>> cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0))
        >>> hands = [cg.Arm("left", [(-0.25, 0.2, 1.0)]), cg.Arm("right", [(-0.25, -0.2, 1.0)])]
        >>> plan = WrenchPlanner(cart, hands).plan((40.0, 0.0, 3.0))
        >>> plan.status, plan.wrenches["left"][:2].round(1).tolist()
        ('optimal', [18.5, -1.9])
    """

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[Arm],
        *,
        objective: Objective | None = None,
        cart_limits: Sequence[CartLimit] = (),
        confidence: float | None = None,
        min_hand_distance: float = 0.0,
        relax: float = 0.0,
        switching_cost: float | Mapping[str, float] = 0.0,
        search_limit: SearchLimit = DEFAULT_SEARCH,
        solver: str | None = None,
        period: float = PERIOD,
    ) -> None:
        number("min_hand_distance", min_hand_distance, 0.0, LARGEST_FLOAT, "give m")
        positive("period", period, LONGEST_PERIOD, "give s")
        number("relax", relax, 0.0, math.inf, "give N and N·m")
        check_kind("search_limit", search_limit, SearchLimit, "write SearchLimit(solves=5000)")
        limits = listed("cart_limits", cart_limits, CartLimit, "write cart_limits=[Skid(0.5)]")
        self._made = cart, objective, RobustLimits(limits, confidence), (min_hand_distance, period)
        self._relax, self._switching_costs = relax, switching_cost
        self._limit, self._decay = search_limit, math.exp(-period / HOLD_TIME)
        self._solver_name, self._last, self._is_warm = solver, LastPlan(0), False
        self._solver, self._asked = QuadraticSolver(name=solver), (0.0, 0.0, 0.0)
        self._compiled: CompiledPlanning | None = None
        self._begin(Terms(cart, arms, *self._made[1:]), ())
        self._names, self._to_effective = self._terms.base.names, np.ascontiguousarray(self._terms.base.basis_b.T)
        self.reset()

    def __repr__(self) -> str:
        base, name = self._terms.base, self._made[0].name
        return brief("WrenchPlanner", name, f"arms {', '.join(base.names)}", type(base.objective).__name__)

    @property
    def needs_estimate(self) -> bool:
        """Whether it has limits of the cart, which hold for the estimate given last."""
        return bool(self._made[2].limits)

    def reset(self) -> None:
        """Forgets the last wrench, contacts and estimate's time."""
        self._last = LastPlan(len(self._terms.sets))
        self._newest_estimate = -math.inf
        if self._compiled is not None:
            self._compiled.forget()
        self._look_back_at(self._last.wrenches)

    def for_arms(self, names: Sequence[str]) -> Self:
        """A planner like this one, which remembers nothing, for some of its arms."""
        other, before = shallow(self), self._terms.base
        other._solver, other._is_warm = QuadraticSolver(name=self._solver_name), False
        other._begin(Terms(self._made[0], [a for a in before.arms if a.name in names], *self._made[1:]), before.names)
        other._names = other._terms.base.names
        other.reset()
        return other

    def start_from(self, wrenches: Mapping[str, ArrayLike], contacts: Mapping[str, ArrayLike] = NOWHERE) -> None:
        """As if the last plan had been these wrenches (6,) in {a} by arm, zero of others, at contacts (3,) in {b};
        others hold where they held."""
        self._last = self._last.started(self._terms.base.names, wrenches, contacts)
        self._look_back_at(scaled_into(self._terms.base.limits, self._last.wrenches))

    def warm_up(self) -> None:
        """Does now what would cost at the first call: workspaces, the fallback's import, and compiled kernels, without
        which planning takes ten times as long: loaded in half a second, or compiled. What it remembers stays."""
        self._is_warm, kept = True, (self._last, self._newest_estimate)
        self.reset()
        self._begin_terms()
        for contacts in (None, None, dict(zip(self._terms.base.names, self._terms.first, strict=True))):
            self.plan((1.0, 0.0, 0.1), contacts)
        self.reset()
        self._last, self._newest_estimate = kept
        self._look_back_at(self._last.wrenches)
        solve_with_clarabel(self._program.at(self._terms.first, np.zeros(len(self._to_effective)), self._cost))

    def plan(
        self,
        wrench: ArrayLike,
        contacts: Mapping[str, ArrayLike] | None = None,
        estimate: Estimate | None = None,
        arms: Sequence[Arm] | None = None,
    ) -> Plan:
        """The best wrenches of the arms, or a proof that there are none, with contacts that would do.

        Args:
            wrench: What the cart shall get: (fx, fy, tau) in {b}, N and N·m.
            contacts: Where arms hold this tick, (3,) in {b}, m; for arms left out the planner chooses.
            estimate: The cart and motion for which `cart_limits` hold from now on; one that is 0.5 s older than the
                newest given is stale.
            arms: The arms that hold the cart from now on, with the limits and candidates that they now have; of others
                the hand is off. The last wrench is scaled into their limits.

        It raises nothing for data: `Plan.status` is then `invalid_input`, and `message` says why."""
        plan = self._plan(wrench, contacts, estimate, arms)
        if plan.status != INFEASIBLE or plan.certificate is None or plan.nearest is None:
            return plan
        question = Question(self._to_effective.dot(read_wrench(wrench)), self._cost)
        held, every = plan.nearest.contacts, self._terms.candidates
        remedy = find_remedy(self._cases, question, None if contacts is None else every, held, every.distance)
        certificate = with_remedy(plan.certificate, remedy, held)
        return replace(plan, certificate=certificate, message=certificate.words)

    def problem(self, wrench: ArrayLike | None = None, contacts: Mapping[str, ArrayLike] = NOWHERE) -> cvxpy.Problem:
        """What the next call of `plan` is to solve, in cvxpy: to be read, changed, and solved by any of its solvers.
        For the wrench (3,) of the last call unless one is given, at contacts (3,) by arm; arms left out hold where they
        held, or at their first candidate. See `tick/next_problem.py` for its names."""
        return next_problem(self._terms, self._last, self._asked if wrench is None else wrench, contacts)

    def plan_or_hold(
        self,
        wrench: ArrayLike,
        contacts: Mapping[str, ArrayLike] | None = None,
        estimate: Estimate | None = None,
        arms: Sequence[Arm] | None = None,
    ) -> Plan:
        """As `plan` but for the search for better contacts, and a safe wrench whatever the status: where there is
        none, the last one, decaying with a time constant of 0.1 s, or as fast as rates of change allow (zero if there
        was none). The arms' limits are convex and hold the zero wrench, so it stays within; a cart that skids
        or tips without the hands is beyond them. After `warm_up`, `certificate`, `message` and `nearest` are found when
        they are asked for."""
        plan = self._plan(wrench, contacts, estimate, arms, at_once=True)
        if plan.is_usable:
            return plan
        shrink = self._terms.shrink(self._last.wrenches, self._decay)
        self._remember(shrink * self._last.wrenches, self._last.contacts)
        by_arm, points = self._answers.by_arm, self._last.contacts_or(self._terms.first)
        held = ContactWrenches(by_arm(self._last.wrenches), by_arm(points), self._terms.yaws)
        told = {"held": held, "wheel_forces": self._terms.wheel_forces, "arms": self._terms.base.arms}
        return Plan.of(vars(plan) | told)

    def _plan(
        self,
        wrench: ArrayLike,
        contacts: Mapping[str, ArrayLike] | None,
        estimate: Estimate | None,
        arms: Sequence[Arm] | None,
        at_once: bool = False,
    ) -> Plan:
        """With `at_once`, one that can't be given is explained later, where that is proven already."""
        start = time.perf_counter()
        try:
            if arms is not None and self._take_arms(arms):  # first: what is held must obey them as well
                self._begin_terms()
            if self._terms.has_postures and self._terms.take_postures(contacts):
                self._begin_terms()
            asked = self._asked = read_wrench(wrench)
            if estimate is not None:
                self._take_estimate(estimate)
            if self._terms.base.looks_at_wheels:
                self._cost = self._terms.cost(self._last.wrenches, asked)
            plan = None if self._compiled is None else self._compiled.at(contacts, asked, self._cost, start)
            if self._compiled is not None and plan is not None:
                return self._remembered(plan, *self._compiled.last)
            candidates = self._terms.candidates if contacts is None else self._given.candidates(contacts)
        except RefusedError as refused:
            return refusal(refused.status, str(refused), start)
        if contacts is not None and self._given.beyond:
            return out_of_reach(self._given.beyond, start)
        if candidates.distance > 0 and candidates.distance > candidates.widest + DISTANCE_TOLERANCE:
            return too_near(candidates, start)
        if (points := candidates.single) is None:
            plan = self._choose(candidates, asked, start, at_once)
            again = plan.is_usable and self._terms.has_postures  # with the limits of the postures there
            return unproven(self._plan(asked, plan.contacts, None, None, at_once)) if again else plan
        target = self._to_effective.dot(asked)
        if at_once and self._compiled is not None and self._compiled.is_infeasible:
            near = FORBIDDEN if self._relax == 0.0 else self._compiled.nearest(asked, self._cost, start)
            if near is not UNPROVEN:
                return self._left_open(lambda then: then._planned(points, target, None, start), start, near)
        return self._planned(points, target, None, start)

    def _left_open(self, explained: Callable[[WrenchPlanner], Plan], start: float, near: Near = FORBIDDEN) -> Plan:
        """Infeasible, as is proven, or relaxed to what is near; why, a planner like this one of now says when asked."""
        then = shallow(self)
        then._terms, then._last, then._compiled = shallow(self._terms), shallow(self._last), None

        @cache
        def explain() -> Plan:
            then._solver, then._cases = QuadraticSolver(), CaseSolver(then._terms.template)
            then._answers, then._program = Answers(then._terms, then._relax), ProgramAtContacts(then._terms)
            return explained(then)

        plan = left_open(near, self._relax, explain, start)
        return self._remembered(plan, *self._compiled.last) if plan.is_usable and self._compiled else plan

    # --- what changes between ticks -----------------------------------------------------------------------

    def _take_estimate(self, estimate: Estimate) -> None:
        newest, before = check_estimate(estimate, self._newest_estimate), self._terms.base.cart_rows
        if self._terms.take_estimate(estimate):
            self._program.drop()
            self._take_last()
            if not self._terms.base.cart_rows.is_like(before):  # margins came, or went
                self._compile()
        self._newest_estimate = newest  # one that is refused makes no later one stale

    def _take_arms(self, arms: Sequence[Arm]) -> bool:
        """True if that changed anything."""
        new, before = read_arms(arms, self._names), self._terms
        if new.keys() == before.sets.keys():
            return before.take_arms(new)
        try:
            terms = Terms(self._made[0], [new[name] for name in self._names if name in new], *self._made[1:])
        except UsageError as error:
            raise RefusedError(INVALID_INPUT, str(error)) from error
        if before.estimate is not None:
            terms.take_estimate(before.estimate)
        self._begin(terms, before.base.names)
        return True

    def _begin(self, terms: Terms, before: Sequence[str]) -> None:
        """What is made for the arms of `terms`; of those `before` what was last is kept."""
        names, costs = terms.base.names, self._switching_costs
        if before and isinstance(costs, Mapping):
            costs = {name: cost for name, cost in costs.items() if name in names}
        self._terms, self._switching = terms, SwitchingCost(costs, names)
        self._last = self._last.among(before, names)
        self._cases, self._given = CaseSolver(terms.template, self._solver_name), GivenContacts(terms)
        self._answers, self._program = Answers(terms, self._relax, self._solver_name), ProgramAtContacts(terms)
        self._compiled, self._cost = None, terms.base.cost(self._last.wrenches)
        self._begin_terms()

    def _begin_terms(self) -> None:
        """Drops what was made for other arms, and scales what is held into the limits of these."""
        self._program.drop()
        if not self._given.fits:
            self._given, self._last.choice = GivenContacts(self._terms), None
        self._compiled = None if self._compiled is None else self._compiled.renewed()
        if self._compiled is None:
            self._compile()
        self._look_back_at(scaled_into(self._terms.base.limits, self._last.wrenches))

    def _compile(self) -> None:
        """Where it is warm, no other solver is asked for, and what is compiled covers the programs."""
        wanted = self._is_warm and self._solver_name is None
        self._compiled = CompiledPlanning.of(self._terms, self._cost) if wanted else None

    def _look_back_at(self, wrenches: Array) -> None:
        self._last.wrenches = wrenches
        self._cost = self._terms.base.cost(wrenches)
        self._take_last()

    def _take_last(self) -> None:
        self._terms.take_last(self._last.wrenches)
        self._cases.template = self._terms.template

    def _remember(self, wrenches: Array, contacts: Array) -> None:
        self._last.wrenches, self._last.contacts = wrenches, contacts
        if self._terms.looks_back:
            self._look_back_at(wrenches)

    def _remembered(self, plan: Plan, wrenches: Array, contacts: Array) -> Plan:
        if self._switching.is_any:
            plan = replace(plan, switched=self._last.moving_to(contacts, self._terms.base.names))
        self._remember(wrenches, contacts)
        return plan

    def _choose(self, candidates: Candidates, asked: Point, start: float, at_once: bool) -> Plan:
        switching, is_own = self._switching.over(candidates, self._last.contacts), candidates is self._terms.candidates
        offered = candidates if switching is None else switching.candidates
        choice = None
        if self._compiled is not None:
            choice = self._compiled.choose(offered, asked, self._cost, self._limit, switching)
            if choice is not None and choice.contacts is not None:
                plan = self._compiled.chosen(choice, asked, start)
                return self._remembered(plan, *self._compiled.last)
        question = Question(self._to_effective.dot(asked), self._cost, switching=switching)
        if choice is not None and at_once and self._relax == 0.0 and choice.complete and choice.bound == np.inf:
            none = choice
            return self._left_open(lambda then: then._none_found(candidates, question, none, start), start)
        if choice is None:
            seed = self._last.choice if question.seed is None and is_own else question.seed
            choice = ContactSearch(offered, self._cases, question, self._limit).run(seed)
        if choice.contacts is None:
            return self._none_found(candidates, question, choice, start)
        if is_own:
            self._last.choice = choice.contacts
        return self._planned(choice.contacts, question.target, choice, start)

    def _none_found(self, candidates: Candidates, question: Question, choice: Choice, start: float) -> Plan:
        if not choice.complete or choice.bound < np.inf:
            return undecided(choice, start)
        wanted = replace(question, distance=True)
        nearest = ContactSearch(candidates, self._cases, wanted, self._limit).run(question.seed)
        if nearest.contacts is None and nearest.complete and nearest.bound == np.inf:
            program = self._program.at(candidates.first, question.target, question.cost)
            certificate = contradiction(self._terms.template, program, question.target)
            return too_near(candidates, start) if certificate is None else certified(certificate, start)
        if nearest.contacts is None:
            status, wrench = NUMERICAL if nearest.complete else TIMEOUT, "the nearest wrench was not found"
            return refusal(status, f"infeasible at every contact, but {wrench}", start)
        whole = replace(choice, solved=choice.solved + nearest.solved)
        plan = self._planned(nearest.contacts, question.target, whole, start)
        return at_nearest(plan, candidates)

    def _planned(self, points: Array, target: Array, choice: Choice | None, start: float) -> Plan:
        """The plan at contacts, which were chosen or given."""
        program = self._program.at(points, target, self._cost)
        solution = self._solver.solve(program)
        proof = None if choice is None else proof_of(choice, solution)
        if choice is None and self._compiled is not None and not solution.message:
            solution = replace(solution, message=f"fallback: {SOLVER} gave no proven answer")
        plan = self._answers.of(Solved(points, program, solution, start), self._last.wrenches, proof)
        if not plan.is_usable or plan.proof is None:
            return plan
        return self._remembered(plan, plan.proof[1].x[: self._terms.base.n], points)
