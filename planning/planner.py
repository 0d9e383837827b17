"""`WrenchPlanner`: what a controller calls at its rate; it checks, chooses contacts, allocates, and
proves."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.contacts import ContactSet, ContactWrenches
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .allocation import conclude
from .allocation_template import AllocationTemplate
from .compiled_allocation import SOLVER, CompiledAllocation, Point
from .compiled_planning import CompiledPlanning
from .contact_bounds import Candidates
from .contact_cases import CaseSolver, Question
from .contact_choice import Choice, ContactSearch, SearchLimit
from .contact_regions import DISTANCE_TOLERANCE
from .infeasibility import Certificate
from .objectives import Objective
from .plan import TIMEOUT, ChoiceProof, Plan
from .plan_inputs import RefusedError, check_estimate, read_contacts, read_wrench
from .quadratic_program import INFEASIBLE, NUMERICAL, OPTIMAL, QPSolution, QuadraticProgram, Residuals
from .solvers import QuadraticSolver, solve_with_clarabel

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.motion import Estimate

PERIOD = 1e-3  # s, between calls of plan_or_hold
HOLD_TIME = 0.1  # s, time constant with which a held wrench decays
DEFAULT_SEARCH = SearchLimit()


class WrenchPlanner:
    """Plans for one cart and its arms. It remembers its last wrench: to hold it, to start the next choice of
    contacts from, and for `Smoothness`."""

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[Arm],
        *,
        objective: Objective | None = None,
        min_hand_distance: float = 0.0,
        search_limit: SearchLimit = DEFAULT_SEARCH,
        period: float = PERIOD,
    ) -> None:
        if not (math.isfinite(min_hand_distance) and min_hand_distance >= 0):
            raise UsageError(f"min_hand_distance: {min_hand_distance} is not a finite number >= 0, in m")
        if not (math.isfinite(period) and period > 0):
            raise UsageError(f"period: {period} is not a finite number > 0, in s")
        self._template = AllocationTemplate.of(cart, arms, objective)
        self._sets = {arm.name: arm.contacts for arm in self._template.arms}
        self._candidates = Candidates.of(list(self._sets.values()), min_hand_distance)
        self._given: dict[str, tuple[float, float, float]] = {}
        self._given_candidates = self._candidates
        self._to_effective = np.ascontiguousarray(self._template.basis_b.T)
        self._limit, self._decay = search_limit, math.exp(-period / HOLD_TIME)
        self._parts = [(name, slice(6 * i, 6 * i + 6)) for i, name in enumerate(self._template.names)]
        self._looks_back = self._template.objective.looks_back
        self._yaws = dict(zip(self._template.names, self._template.yaws.tolist(), strict=True))
        self._solver, self._cases = QuadraticSolver(), CaseSolver(self._template)
        self._compiled: CompiledPlanning | None = None
        self._program: QuadraticProgram | None = None
        self._program_points = self._shown_points = np.zeros((0, 3))
        self._shown: dict[str, Array] = {}
        self.reset()

    def reset(self) -> None:
        """Forgets the last wrench, contacts and estimate."""
        self._last = np.zeros(self._template.n)
        self._last_points = np.array([contacts.first for contacts in self._sets.values()])
        self._last_choice: Array | None = None
        self._cost = self._template.cost(self._last)
        self._newest_estimate = -math.inf
        if self._compiled is not None:
            self._compiled.forget()
            self._compiled.allocation.set_gradient(self._cost)

    def warm_up(self) -> None:
        """Does now what would cost at the first call: workspaces, the import of the fallback solver, and the compiled
        kernels, without which planning takes ten times as long. They are loaded in half a second, and compiled in half
        a minute the very first time on a machine."""
        self._compiled = CompiledPlanning.of(self._template, self._cost, self._candidates)
        self.plan((0.0, 0.0, 0.0))
        self.plan((1.0, 0.0, 0.1))
        self.reset()
        solve_with_clarabel(self._program_at(self._last_points, np.zeros(self._template.basis_b.shape[1])))

    # --- planning -----------------------------------------------------------------------------------------

    def plan(
        self,
        wrench: ArrayLike,
        contacts: Mapping[str, ArrayLike] | None = None,
        estimate: Estimate | None = None,
    ) -> Plan:
        """`wrench` is the desired (fx, fy, tau) on the cart in {b}; `contacts` (3,) by arm are fixed this
        tick, and for arms left out the planner chooses. An estimate 0.5 s older than the newest given is
        stale."""
        start = time.perf_counter()
        try:
            asked = read_wrench(wrench)
            if estimate is not None:
                self._newest_estimate = check_estimate(estimate, self._newest_estimate)
            if self._compiled is not None:
                points = self._compiled.points(contacts)
                if points is not None and self._compiled.allocation.solve(asked, points):
                    return self._compiled_answer(self._compiled.allocation, points, None, start)
            candidates = self._candidates if contacts is None else self._narrowed(contacts)
        except RefusedError as refused:
            return self._refusal(refused.status, str(refused), start)
        if candidates.distance > 0 and candidates.distance > candidates.widest + DISTANCE_TOLERANCE:
            return self._too_near(candidates, start)
        points = candidates.single
        if points is None:
            return self._choose(candidates, asked, start)
        return self._solve_at(points, asked, start)

    def plan_or_hold(self, wrench: ArrayLike, contacts: Mapping[str, ArrayLike] | None = None) -> Plan:
        """As `plan`, and a safe wrench whatever the status: when it is not `optimal`, the last one, decaying
        with a time constant of 0.1 s (zero if there was none). Limits are convex and hold the zero wrench, so
        it stays within."""
        plan = self.plan(wrench, contacts)
        if plan.status == OPTIMAL:
            return plan
        self._remember(self._decay * self._last, self._last_points)
        held = ContactWrenches(self._by_arm(self._last), self._by_arm(self._last_points), self._yaws)
        return replace(plan, held=held)

    # --- contacts -----------------------------------------------------------------------------------------

    def _narrowed(self, contacts: Mapping[str, ArrayLike]) -> Candidates:
        """The candidates with some arms' contacts fixed; those of the last call where these are the same."""
        given = read_contacts(contacts, self._template.names)
        if given != self._given:
            self._given_candidates = self._fixed_at(given)
            self._given = given
        return self._given_candidates

    def _fixed_at(self, given: dict[str, tuple[float, float, float]]) -> Candidates:
        if not given:
            return self._candidates
        if len(given) == len(self._sets):
            return Candidates.at([given[name] for name in self._sets], self._candidates.distance)
        sets = [ContactSet((given[name],)) if name in given else own for name, own in self._sets.items()]
        return Candidates.of(sets, self._candidates.distance)

    def _solve_at(self, points: Array, asked: Point, start: float) -> Plan:
        program = self._program_at(points, self._to_effective.dot(asked))
        solution = self._solver.solve(program)
        if self._compiled is not None and solution.status == OPTIMAL:
            solution = replace(solution, message=f"fallback: {SOLVER} gave no proven answer")
        if solution.status != OPTIMAL:
            return self._concluded(points, program, solution, None, start)
        return self._solved(points, program, solution, ChoiceProof(solution.cost, 0.0, 1), start)

    def _choose(self, candidates: Candidates, asked: Point, start: float) -> Plan:
        target = self._to_effective.dot(asked)
        question = Question(target, self._cost)
        choice = None
        if self._compiled is not None:
            choice = self._compiled.choose(asked, candidates, self._cost, self._limit)
            if choice is not None and choice.contacts is not None:
                return self._compiled_answer(self._compiled.allocation, choice.contacts, choice, start)
        if choice is None:
            seed = self._last_choice if candidates is self._candidates else None
            choice = ContactSearch(candidates, self._cases, question, self._limit).run(seed)
        if choice.contacts is None:
            return self._none_found(candidates, question, choice, start)
        if candidates is self._candidates:
            self._last_choice = choice.contacts
        program = self._program_at(choice.contacts, target)
        solution = self._solver.solve(program)
        cost = solution.cost if solution.status == OPTIMAL else choice.value
        gap = max(0.0, cost - choice.bound) / max(1.0, abs(cost))
        proof = ChoiceProof(choice.bound, gap, choice.solved + 1)
        return self._concluded(choice.contacts, program, solution, proof, start)

    def _none_found(self, candidates: Candidates, question: Question, choice: Choice, start: float) -> Plan:
        if not choice.complete:
            message = f"no feasible contacts among the {choice.solved} programs solved until the search's limit"
            return self._refusal(TIMEOUT, message, start)
        if np.isfinite(choice.bound):
            return self._refusal(NUMERICAL, "at some contacts no solver gave a verified answer", start)
        nearest = ContactSearch(candidates, self._cases, replace(question, distance=True), self._limit).run()
        if nearest.contacts is None and nearest.complete and not np.isfinite(nearest.bound):
            return self._too_near(candidates, start)
        if nearest.contacts is None:
            return self._refusal(NUMERICAL, "infeasible at every contact, but the nearest wrench was not found", start)
        program = self._program_at(nearest.contacts, question.target)
        proof = ChoiceProof(np.inf, np.inf, choice.solved + nearest.solved + 1)
        plan = self._concluded(nearest.contacts, program, self._solver.solve(program), proof, start)
        if plan.certificate is None:
            return plan
        others = f"at the nearest of {candidates.count} choices of contacts; none is feasible"
        words = f"{plan.certificate.words} ({others})"
        return replace(plan, certificate=replace(plan.certificate, words=words), message=words)

    def _program_at(self, points: Array, target: Array) -> QuadraticProgram:
        """The program at contacts; where these are as at the last call, only its equality's value is new."""
        same = points is self._program_points or np.array_equal(points, self._program_points)
        if self._program is None or not same:
            self._program = self._template.program(self._template.contact_rows(points), target, self._cost)
            self._program_points = points
        program = self._program.with_equality_value(target)
        if self._looks_back:
            program = program.with_gradient(self._cost.gradient, self._cost.constant)
        return program

    # --- answers ------------------------------------------------------------------------------------------

    def _compiled_answer(self, answer: CompiledAllocation, points: Array, choice: Choice | None, start: float) -> Plan:
        wrenches, numbers = answer.wrenches, answer.numbers
        self._remember(wrenches, points)
        fields = {
            "wrenches": {name: wrenches[part] for name, part in self._parts},
            "contacts": self._contacts_at(points),
            "yaws": self._yaws,
            "effort": numbers.pop(),
            "active": answer.active,
            "residuals": Residuals(*numbers),
            "choice": ChoiceProof(numbers[4], 0.0, 1) if choice is None else choice.proof,
            "solve_time": time.perf_counter() - start,
            "solver": SOLVER,
            "message": "",
        }
        return Plan.optimal(fields)

    def _solved(
        self, points: Array, program: QuadraticProgram, solution: QPSolution, proof: ChoiceProof, start: float
    ) -> Plan:
        self._remember(solution.x, points)
        return Plan(
            status=OPTIMAL,
            wrenches=self._by_arm(solution.x),
            contacts=self._contacts_at(points),
            yaws=self._yaws,
            effort=self._template.effort(solution.x),
            active=program.active(solution),
            residuals=solution.residuals,
            choice=proof,
            solve_time=time.perf_counter() - start,
            solver=solution.solver,
            message=solution.message,
        )

    def _concluded(
        self,
        points: Array,
        program: QuadraticProgram,
        solution: QPSolution,
        proof: ChoiceProof | None,
        start: float,
    ) -> Plan:
        """As `_solved`, for what may have failed."""
        allocation = conclude(self._template, points, program, solution)
        if allocation.status == OPTIMAL:
            proof = proof or ChoiceProof(allocation.solution.cost, 0.0, 1)
            return self._solved(points, program, allocation.solution, proof, start)
        words = allocation.certificate.words if allocation.certificate else allocation.solution.message
        return Plan(
            status=allocation.status,
            choice=proof,
            certificate=allocation.certificate,
            solve_time=time.perf_counter() - start,
            solver=allocation.solution.solver,
            message=words,
        )

    def _too_near(self, candidates: Candidates, start: float) -> Plan:
        asked, most = candidates.distance, candidates.widest
        words = f"min_hand_distance: no choice of contacts keeps the hands {asked:g} m apart"
        if most < asked:
            words += f"; at most {most:.6g} m is possible"
        else:
            most = math.nan  # proven by exhaustion
        certificate = Certificate(words, asked, most, limits={"min_hand_distance": asked})
        spent = time.perf_counter() - start
        return Plan(INFEASIBLE, certificate=certificate, solve_time=spent, message=words)

    def _refusal(self, status: str, message: str, start: float) -> Plan:
        return Plan(status, solve_time=time.perf_counter() - start, message=message)

    def _remember(self, wrenches: Array, points: Array) -> None:
        wrenches.setflags(write=False)  # plans show them
        self._last, self._last_points = wrenches, points
        if self._looks_back:
            self._cost = self._template.cost(wrenches)
            if self._compiled is not None:
                self._compiled.allocation.set_gradient(self._cost)

    def _contacts_at(self, points: Array) -> dict[str, Array]:
        if points is not self._shown_points:
            points.setflags(write=False)
            self._shown_points = points
            self._shown = {name: points[i] for i, (name, _) in enumerate(self._parts)}
        return self._shown.copy()

    def _by_arm(self, values: Array) -> dict[str, Array]:
        return dict(zip(self._template.names, values.reshape(len(self._sets), -1), strict=True))
