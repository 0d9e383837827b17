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
from cartgrasp.checks import MAX_FLOAT, brief, check_kind, listed, number, positive
from cartgrasp.contacts import ContactWrenches
from cartgrasp.frames import Array
from cartgrasp.garbage_collection import freeze_live_objects
from cartgrasp.shallow_copy import shallow_copy

from .allocation.contradiction import contradiction
from .contacts.contact_bounds import Candidates
from .contacts.contact_cases import Question
from .contacts.contact_choice import Choice, ContactSearch, SearchLimit
from .contacts.contact_regions import DISTANCE_TOLERANCE
from .limits import CartLimit
from .limits.robust import RobustLimits
from .objectives import Objective
from .plan import RELAXED, TIMEOUT, UNSOLVED, Plan
from .quadratic_program import INFEASIBLE, NUMERICAL
from .solvers import solve_with_clarabel
from .tick.answers import Solved, proof_of
from .tick.compiled_allocation import SOLVER, Point
from .tick.compiled_nearest import FORBIDDEN, UNPROVEN, Near, left_open
from .tick.plan_inputs import RefusedError, read_beside, read_wrench
from .tick.program_at_contacts import next_problem
from .tick.refusals import at_nearest, certified, out_of_reach, refusal, too_near, undecided, unproven
from .tick.remedy import find_remedy, with_remedy
from .tick.stopping import Stop, Stopping
from .tick.terms import Settings
from .tick.tick_state import TickState

if TYPE_CHECKING:
    import cvxpy

    from cartgrasp.model import CartModel
    from cartgrasp.motion import Estimate

DEFAULT_PERIOD, MAX_PERIOD = 1e-3, 0.5  # s, between calls of plan_or_hold
HOLD_TIME = 0.1  # s: time constant with which a held wrench decays
DEFAULT_SEARCH = SearchLimit()
NOWHERE: Mapping[str, ArrayLike] = {}


# Many methods: ten are the contract's; the rest are one call's branches, which share the tick's state.
class WrenchPlanner:
    """Spreads a planar wrench over the arms of one cart, within every limit, with a proof.

    It remembers its last wrench and contacts: to hold them, to start the next choice of contacts from, for
    `Smoothness`, and for rates of change (from zero at first).

    Args:
        cart: What is pushed.
        arms: What holds it, each arm with its limits and places to hold.
        objective: What is least: `WeightedWrench()`, by the arms' own weights, unless given.
        cart_limits: Limits of the hands together: `Skid`, `TipOver`, `SideForce`, `InternalForce`, or a `CartLimit` or
            `FloorLimit` of your own.
        confidence: The probability (0.5 to below 1) with which all `cart_limits` of the floor hold together, by the
            covariance of the estimate given last (robust.py): `Skid`, `TipOver`, `SideForce`, your `FloorLimit`. Others
            hold for the cart as it is believed to be, and with None all do.
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

    # Many parameters: what a planner is told once, all but cart and arms with defaults.
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
        period: float = DEFAULT_PERIOD,
    ) -> None:
        number("min_hand_distance", min_hand_distance, 0.0, MAX_FLOAT, "give m")
        positive("period", period, MAX_PERIOD, "give s")
        number("relax", relax, 0.0, math.inf, "give N and N·m")
        check_kind("search_limit", search_limit, SearchLimit, "write SearchLimit(solves=5000)")
        limits = listed("cart_limits", cart_limits, CartLimit, "write cart_limits=[Skid(0.5)]")
        margins = RobustLimits(limits, confidence)
        self._made = Settings(cart, objective, margins, min_hand_distance, period, relax, switching_cost, solver)
        self._limit, self._decay, self._asked = search_limit, math.exp(-period / HOLD_TIME), (0.0, 0.0, 0.0)
        self._now = TickState(self._made, arms)
        self._to_effective = np.ascontiguousarray(self._now.terms.base.basis_b.T)

    def __repr__(self) -> str:
        base, name = self._now.terms.base, self._made.cart.name
        return brief("WrenchPlanner", name, f"arms {', '.join(base.names)}", type(base.objective).__name__)

    @property
    def needs_estimate(self) -> bool:
        """Whether its limits or its objective look at the cart as estimated last."""
        return bool(self._made.cart_limits.limits) or self._now.terms.base.looks_at_wheels

    @property
    def confidence(self) -> float | None:
        """With which limits of the cart hold."""
        return self._made.cart_limits.confidence

    def reset(self) -> None:
        """Forgets the last wrench, contacts and estimate's time."""
        self._now.reset()

    def for_arms(self, names: Sequence[str], at_any_rate: bool = False) -> Self:
        """A planner like this one, which remembers nothing, for some of its arms; as they are, or without limits of
        their rates."""
        other = shallow_copy(self)
        other._made = replace(self._made, switching_cost=self._made.costs_of(names))
        arms = [arm for arm in self._now.terms.base.arms if arm.name in names]
        other._now = TickState(other._made, [arm.without_rate() for arm in arms] if at_any_rate else arms)
        return other

    @property
    def period(self) -> float:
        """s between calls."""
        return self._made.period

    def start_from(self, wrenches: Mapping[str, ArrayLike], contacts: Mapping[str, ArrayLike] = NOWHERE) -> None:
        """As if the last plan had been these wrenches (6,) in {a} by arm, zero of others, at contacts (3,) in {b};
        others hold where they held."""
        self._now.start_from(wrenches, contacts)

    def warm_up(self) -> None:
        """Does now what would cost at the first call: workspaces, the fallback's import, and compiled kernels, without
        which planning takes ten times as long: loaded in half a second, or compiled. What it remembers stays. What
        lives by then is no more looked at by the interpreter's collector of garbage, which would pause for 80 ms."""
        now = self._now
        at_first = dict(zip(now.terms.base.names, now.terms.first, strict=True))
        now.warm_up(lambda: [self.plan((1.0, 0.0, 0.1), contacts) for contacts in (None, None, at_first)])
        solve_with_clarabel(now.program.at(now.terms.first, np.zeros(len(self._to_effective)), now.cost))
        freeze_live_objects()

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
        question = Question(self._to_effective.dot(read_wrench(wrench)), self._now.cost)
        held, every = plan.nearest.contacts, self._now.terms.candidates
        remedy = find_remedy(self._now.cases, question, None if contacts is None else every, held, every.distance)
        certificate = with_remedy(plan.certificate, remedy, held)
        return replace(plan, certificate=certificate, message=certificate.words)

    def problem(self, wrench: ArrayLike | None = None, contacts: Mapping[str, ArrayLike] = NOWHERE) -> cvxpy.Problem:
        """What the next call of `plan` is to solve, in cvxpy: to be read, changed, and solved by any of its solvers.
        For the wrench (3,) of the last call unless one is given, at contacts (3,) by arm; arms left out hold where they
        held, or at their first candidate. See `tick/program_at_contacts.py` for its names."""
        return next_problem(self._now.terms, self._now.last, self._asked if wrench is None else wrench, contacts)

    def plan_or_hold(
        self,
        wrench: ArrayLike,
        contacts: Mapping[str, ArrayLike] | None = None,
        estimate: Estimate | None = None,
        arms: Sequence[Arm] | None = None,
        stop: Stop | None = None,
        beside: ContactWrenches | None = None,
    ) -> Plan:
        """As `plan` but for the search for better contacts, and a safe wrench whatever the status: where there is
        none, the last one, decaying with a time constant of 0.1 s, or as fast as rates of change allow (zero if there
        was none). The arms' limits are convex and hold the zero wrench, so it stays within; a cart that skids
        or tips without the hands is beyond them. After `warm_up`, `certificate`, `message` and `nearest` are found when
        they are asked for.

        Args:
            stop: Gives the wrench (3,) in {b} under which velocities fade at a share (0 to 1) of the rate that brings
                the cart to rest. Margins then give way where they leave no gentle stop (stopping.py), which
                `Plan.stops` says; and where no wrench keeps the limits, `held` is the stop.
            beside: What others give the cart this tick: part of `wrench`, of `Plan.cart_wrench` and of what limits of
                the cart on the floor hold for."""
        plan = self._plan(wrench, contacts, estimate, arms, beside, at_once=True)
        now, terms = self._now, self._now.terms
        if stop is not None and terms.limits_floor and plan.status in (RELAXED, *UNSOLVED):

            def planned(wanted: ArrayLike, exact: bool) -> Plan:
                return self._plan(wanted, contacts, None, None, beside, at_once=True, exact=exact)

            asked = self._asked
            before = now.before if plan.is_usable else now.last
            plan = Stopping(now, before, now.stop_share, stop, planned).of(plan, asked)
            self._asked = asked
        now.stop_share = now.stop_share if plan.stops else 1.0
        if plan.is_usable:
            return plan
        told = {"wheel_forces": terms.wheel_forces, "arms": terms.base.arms, "beside": terms.beside}
        if plan.held is None:
            now.remember(terms.shrink(now.last.wrenches, self._decay) * now.last.wrenches, now.last.contacts)
            by_arm, points = now.answers.by_arm, now.last.contacts_or(terms.first)
            told["held"] = ContactWrenches(by_arm(now.last.wrenches), by_arm(points), terms.yaws)
        return Plan.of(vars(plan) | told)

    def _plan(
        self,
        wrench: ArrayLike,
        contacts: Mapping[str, ArrayLike] | None,
        estimate: Estimate | None,
        arms: Sequence[Arm] | None,
        beside: ContactWrenches | None = None,
        at_once: bool = False,
        exact: bool = False,
    ) -> Plan:
        """With `at_once`, one that can't be given is explained later, where that is proven already; with `exact` as
        well, the nearest is then not looked for."""
        start, now = time.perf_counter(), self._now
        try:
            if arms is not None:
                now.take_arms(arms)  # first: what is held must obey them as well
            now.take_postures(contacts)
            self._asked = read_wrench(wrench)
            now.terms.take_beside(read_beside(beside))
            if estimate is not None:
                now.take_estimate(estimate)
            if now.terms.base.looks_at_wheels:
                now.cost = now.terms.cost(now.last.wrenches, self._asked)
            asked = now.terms.rest_of(self._asked)
            plan = None if now.compiled is None else now.compiled.at(contacts, asked, now.cost, start)
            if now.compiled is not None and plan is not None:
                return self._remembered(plan, *now.compiled.last)
            candidates = now.terms.candidates if contacts is None else now.given.candidates(contacts)
        except RefusedError as refused:
            return refusal(refused.status, str(refused), start)
        if contacts is not None and now.given.beyond:
            return out_of_reach(now.given.beyond, start)
        if candidates.distance > 0 and candidates.distance > candidates.widest + DISTANCE_TOLERANCE:
            return too_near(candidates, start)
        if (points := candidates.single) is None:
            last, plan = now.last, self._choose(candidates, asked, start, at_once)
            if not (plan.is_usable and now.terms.has_postures):
                return plan
            now.go_back_to(last._replace(choice=now.last.choice))  # this one was not given
            return unproven(self._plan(self._asked, plan.contacts, None, None, beside, at_once))  # with postures there
        target = self._to_effective.dot(asked)
        if at_once and now.compiled is not None and now.compiled.is_infeasible:
            near = FORBIDDEN if exact or self._made.relax == 0.0 else now.compiled.nearest(asked, now.cost, start)
            if near is not UNPROVEN:
                return self._left_open(lambda then: then._planned(points, target, None, start), start, near)
        return self._planned(points, target, None, start, exact)

    def _left_open(self, explained: Callable[[WrenchPlanner], Plan], start: float, near: Near = FORBIDDEN) -> Plan:
        """Infeasible, as is proven, or relaxed to what is near; why, a planner like this one of now says when asked."""
        then, compiled = shallow_copy(self), self._now.compiled
        then._now = self._now.as_it_is()

        @cache
        def explain() -> Plan:
            then._now.renew_solvers()
            return explained(then)

        plan = left_open(near, self._made.relax, explain, start)
        return self._remembered(plan, *compiled.last) if plan.is_usable and compiled else plan

    def _remembered(self, plan: Plan, wrenches: Array, contacts: Array) -> Plan:
        if self._now.switching.is_any:
            switched = self._now.last.moving_to(contacts, self._now.terms.base.names)
            plan = Plan.of(vars(plan) | {"switched": switched})
        self._now.remember(wrenches, contacts)
        return plan

    def _choose(self, candidates: Candidates, asked: Point, start: float, at_once: bool) -> Plan:
        now = self._now
        switching, is_own = now.switching.over(candidates, now.last.contacts), candidates is now.terms.candidates
        offered = candidates if switching is None else switching.candidates
        choice = None
        if now.compiled is not None:
            choice = now.compiled.choose(offered, asked, now.cost, self._limit, switching)
            if choice is not None and choice.contacts is not None:
                plan = now.compiled.chosen(choice, asked, start)
                return self._remembered(plan, *now.compiled.last)
        question = Question(self._to_effective.dot(asked), now.cost, switching=switching)
        if choice is not None and at_once and self._made.relax == 0.0 and choice.complete and choice.bound == np.inf:
            none = choice
            return self._left_open(lambda then: then._none_found(candidates, question, none, start), start)
        if choice is None:
            seed = now.last.choice if question.seed is None and is_own else question.seed
            choice = ContactSearch(offered, now.cases, question, self._limit).run(seed)
        if choice.contacts is None:
            return self._none_found(candidates, question, choice, start)
        if is_own:
            now.last = now.last._replace(choice=choice.contacts)
        return self._planned(choice.contacts, question.target, choice, start)

    def _none_found(self, candidates: Candidates, question: Question, choice: Choice, start: float) -> Plan:
        if not choice.complete or choice.bound < np.inf:
            return undecided(choice, start)
        now, wanted = self._now, replace(question, distance=True)
        nearest = ContactSearch(candidates, now.cases, wanted, self._limit).run(question.seed)
        if nearest.contacts is None and nearest.complete and nearest.bound == np.inf:
            program = now.program.at(candidates.first, question.target, question.cost)
            certificate = contradiction(now.terms.template, program, question.target)
            return too_near(candidates, start) if certificate is None else certified(certificate, start)
        if nearest.contacts is None:
            status, wrench = NUMERICAL if nearest.complete else TIMEOUT, "the nearest wrench was not found"
            return refusal(status, f"infeasible at every contact, but {wrench}", start)
        whole = replace(choice, solved=choice.solved + nearest.solved)
        plan = self._planned(nearest.contacts, question.target, whole, start)
        return at_nearest(plan, candidates)

    def _planned(self, points: Array, target: Array, choice: Choice | None, start: float, exact: bool = False) -> Plan:
        """The plan at contacts, which were chosen or given; with `exact`, an infeasible one is not explained."""
        now = self._now
        program = now.program.at(points, target, now.cost)
        solution = now.solver.solve(program)
        if exact and solution.status == INFEASIBLE:
            return refusal(INFEASIBLE, solution.message, start)
        proof = None if choice is None else proof_of(choice, solution)
        if choice is None and now.compiled is not None and not solution.message:
            solution = replace(solution, message=f"fallback: {SOLVER} gave no proven answer")
        plan = now.answers.of(Solved(points, program, solution, start), now.last.wrenches, proof)
        if not plan.is_usable or plan.proof is None:
            return plan
        return self._remembered(plan, plan.proof[1].x[: now.terms.base.n], points)
