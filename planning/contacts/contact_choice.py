"""Which contacts to hold: a proven optimum over points and segments of several arms, hands a distance apart.

Best-first branch and bound. A node is a table of choices (an option for each arm), bounded by the cuts of everything
solved so far, or a box of contacts, bounded by its parent's optimum. A box is solved over the hull of its allowed
contacts (contact_regions.py), which is exact for the wrench (allocation_template.py), as one case for each pair of
extreme vertices. If contacts that realise the optimum keep the distance, the box is done; else it is halved.

With three or more arms on segments and a distance that binds, the hull is the box itself and convergence is linear: the
limit on solves may end the search first. The incumbent is then returned with the gap that is certified.

What options cost beside the effort (switching_cost.py) is a constant of each, and adds to its bounds and to its cases.
"""

from __future__ import annotations

import heapq
import time
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..plan import ChoiceProof
from ..quadratic_program import EQUALITY_TOLERANCE
from .contact_bounds import MAX_TABLE_CHOICES, Candidates, ChoiceTable, CutPool
from .contact_cases import GAP_TOLERANCE, Answer, CaseSolver, Question
from .contact_regions import DISTANCE_TOLERANCE, Box, Region, boxes, hand_distance

MIN_BOX_WIDTH = 1e-9  # m
WIDENED_GAP = 1e-3


@dataclass(frozen=True, eq=False)
class Choice:
    """The best contacts (n, 3) found and their value, None and infinite if there are none; the true optimum
    is not below `bound`. `solved` counts programs; `complete` is False if the search ended at its limit. `switching` is
    what these contacts cost beside the effort."""

    contacts: Array | None
    value: float
    bound: float
    solved: int
    complete: bool
    switching: float = 0.0

    @property
    def gap(self) -> float:
        """Relative: (value - bound) / max(1, |value|)."""
        if self.contacts is None:
            return np.inf
        return max(0.0, (self.value - self.bound) / max(1.0, abs(self.value)))

    @property
    def proof(self) -> ChoiceProof:
        return ChoiceProof(self.bound, self.gap, self.solved, self.switching)


@dataclass(frozen=True)
class SearchLimit:
    """When a search among contacts ends before its optimum is proven; the plan then says how far from it at most.

    Args:
        solves: Programs solved at most.
        seconds: At most; None: no deadline.
        gap: The relative gap that is good enough. None: 1e-9, or 1e-3 over segments where a cart's limit depends on
            the contact: that takes tens to hundreds of programs, and 1e-9 thousands.

    Raises:
        UsageError: One is negative.
    """

    solves: int = 5000
    seconds: float | None = None
    gap: float | None = None

    def __post_init__(self) -> None:
        number("search_limit: solves", self.solves, 0, MAX_FLOAT)
        for name, value in (("seconds", self.seconds), ("gap", self.gap)):
            if value is not None:
                number(f"search_limit: {name}", value, 0.0)

    def gap_over(self, candidates: Candidates, template: AllocationTemplate) -> float:
        """The gap that is good enough for these candidates."""
        if self.gap is not None:
            return self.gap
        widened = candidates.has_segments and bool(template.cart_rows.of_sum.any())
        return WIDENED_GAP if widened else GAP_TOLERANCE


# Many methods: one branch and bound in its steps, which share a frontier, an incumbent and a budget.
class ContactSearch:
    """One search over candidates; `run` once."""

    def __init__(
        self, candidates: Candidates, solver: CaseSolver, question: Question, limit: SearchLimit = SearchLimit()
    ) -> None:
        self._candidates, self._solver, self._question, self._limit = candidates, solver, question, limit
        scale = max(1.0, float(np.abs(question.target).max()))
        charges = None if question.switching is None or question.distance else question.switching.charges
        self._cuts = CutPool(candidates, solver.template, EQUALITY_TOLERANCE * scale, charges)
        self._heap: list[tuple[float, int, ChoiceTable | Box]] = []
        self._pushed, self._before, self._start = 0, solver.solved, time.perf_counter()
        self._best, self._contacts = np.inf, np.zeros(0)
        self._floor, self._gap = np.inf, limit.gap_over(candidates, solver.template)

    def run(self, seed: Array | None = None) -> Choice:
        """`seed` (n, 3) is tried first, such as the contacts of the last tick."""
        if seed is not None and self._keeps_distance(seed):
            self._try(seed)
        self._push(-np.inf, self._cuts.children((), self._next_arms(0)))
        while self._heap and self._heap[0][0] < self._cutoff and not self._spent():
            bound, _, node = heapq.heappop(self._heap)
            if isinstance(node, Box):
                self._solve_box(bound, node)
            else:
                self._visit(node)
        left = self._heap[0][0] if self._heap else np.inf
        found, bound = self._contacts if np.isfinite(self._best) else None, min(left, self._best, self._floor)
        if bound == -np.inf:
            bound = min(self._best, self._question.least(self._solver.template))
        return Choice(
            contacts=found,
            value=self._best,
            bound=float(bound),
            solved=self._solver.solved - self._before,
            complete=not self._spent() or left >= self._cutoff,
            switching=0.0 if found is None else self._question.charge(found, found),
        )

    # --- nodes --------------------------------------------------------------------------------------------

    def _visit(self, table: ChoiceTable) -> None:
        """Brings a table up to date; if it still holds the least bound, its best choice is taken up."""
        self._cuts.refresh(table)
        bound = table.least
        if bound >= self._cutoff or (self._heap and bound > self._heap[0][0]):
            self._push(bound, table)
            return
        choice = table.take()
        self._push(table.least, table)
        if len(choice) < self._candidates.n_arms:
            self._push(bound, self._cuts.children(choice, self._next_arms(len(choice))))
            return
        for box in boxes(self._candidates.pieces(choice), self._candidates.distance):
            self._solve_box(bound, box)

    def _next_arms(self, start: int) -> int:
        """How many arms one table takes in: as many as the last ones that it has room for, or one."""
        sizes = np.diff(self._candidates.starts)[start:]
        return len(sizes) if np.prod(sizes, dtype=float) <= MAX_TABLE_CHOICES else 1

    def _solve_box(self, bound: float, box: Box) -> None:
        region = Region.of(box, self._candidates.distance)
        if region is None:
            return
        answer = self._best_case(bound, region)
        if answer is None:
            return
        contacts = self._realise(region, answer)
        if self._keeps_distance(contacts) and self._keeps_cart_limits(region, contacts, answer):
            self._best, self._contacts = answer.value, contacts
            return
        self._try_near(region, contacts)
        if box.size < MIN_BOX_WIDTH:
            self._leave(answer.value)
            return
        for half in box.halves():
            self._push(max(bound, answer.value), half)

    def _try_near(self, region: Region, contacts: Array) -> None:
        """Looks for an incumbent at contacts that keep the distance: these, or the region's nearest vertex."""
        if self._keeps_distance(contacts):
            self._try(contacts)
            return
        allowed = region.vertices[hand_distance(region.vertices) >= self._candidates.distance - DISTANCE_TOLERANCE]
        if len(allowed):
            away = np.linalg.norm(allowed - contacts, axis=(1, 2))
            self._try(allowed[away.argmin()])

    def _best_case(self, bound: float, region: Region) -> Answer | None:
        """The least over the region's pairs of extreme vertices; pairs that a cut puts above it are left out."""
        pairs, best = region.extremes(), None
        charge = self._question.charge(region.box.low, region.box.high)
        if self._solver.template.moment_row is None:
            pairs = pairs[:1]
        high, low = (region.vertices[list(side)] for side in zip(*pairs, strict=True))
        comparable = len(pairs) > 1 and not len(self._solver.template.cart_rows.low)  # else a cut bounds no pair
        bounds = self._cuts.at(high, low) + charge if comparable else np.full(len(pairs), bound)
        for i in np.argsort(bounds):
            lowest = max(bound, bounds[i])
            if comparable:  # by the cuts of the pairs before as well
                lowest = max(lowest, self._cuts.at(high[i : i + 1], low[i : i + 1])[0] + charge)
            if lowest >= self._cutoff or (best and lowest >= best.value):
                self._leave(lowest if lowest >= self._cutoff else np.inf)
                continue
            answer = self._ask(high[i], low[i], charge, region.vertices)
            if not answer.proven:
                self._leave(lowest)
            elif answer.value >= self._cutoff:
                self._leave(answer.value)
            elif best is None or answer.value < best.value:
                best = answer
        return best

    # --- answers ------------------------------------------------------------------------------------------

    def _ask(self, high: Array, low: Array, charge: float, hull: Array | None = None) -> Answer:
        answer = self._solver.answer(self._question, high, low, hull)
        if answer.cut is not None:
            self._cuts.add(answer.cut)
        return replace(answer, value=answer.value + charge) if charge else answer

    def _try(self, contacts: Array) -> None:
        answer = self._ask(contacts, contacts, self._question.charge(contacts, contacts))
        if answer.value < self._best:
            self._best, self._contacts = answer.value, contacts

    def _realise(self, region: Region, answer: Answer) -> Array:
        """Contacts in a region at which the wrenches give what was reached: of all, the hands farthest apart.

        They are a slice of the region; its vertices are where the moment crosses zero between two of the region's.
        """
        if len(region.s) == 1:
            return np.asarray(region.vertices[0])
        rows, row = self._solver.template.contact_rows(region.vertices), self._solver.template.moment_row
        excess = np.zeros(len(region.s))
        if row is not None:
            excess = np.einsum("vnj,nj->v", rows[:, :, -1], answer.wrenches.reshape(-1, 6)) - answer.reached[row]
        excess[np.abs(excess) < 1e-13 * max(1.0, float(np.abs(excess).max()))] = 0.0
        one, other = np.triu_indices(len(excess))
        crosses = excess[one] * excess[other] <= 0
        if not crosses.any():
            return np.asarray(region.vertices[np.abs(excess).argmin()])
        one, other = one[crosses], other[crosses]
        span = excess[one] - excess[other]
        weight = np.where(span == 0, 0.5, excess[one] / np.where(span == 0, 1.0, span))
        s = region.s[one] + weight[:, None] * (region.s[other] - region.s[one])
        if self._candidates.distance <= 0:
            return region.box.at(s.mean(axis=0))
        contacts = region.box.at(s)
        return np.asarray(contacts[hand_distance(contacts).argmax()])

    # --- limits -------------------------------------------------------------------------------------------

    @property
    def _cutoff(self) -> float:
        return self._best - self._question.tolerance(self._best, self._gap) if np.isfinite(self._best) else np.inf

    def _keeps_distance(self, contacts: Array) -> bool:
        return bool(hand_distance(contacts) >= self._candidates.distance - DISTANCE_TOLERANCE)

    def _keeps_cart_limits(self, region: Region, contacts: Array, answer: Answer) -> bool:
        """At a point they were limits of the case; over a range they were widened."""
        template = self._solver.template
        c = len(template.cart_rows.low)
        if c == 0 or len(region.s) == 1:
            return True
        values = np.einsum("nkj,nj->k", template.contact_rows(contacts)[:, :c], answer.wrenches.reshape(-1, 6))
        rows = template.cart_rows
        beyond = np.maximum(values - rows.high, rows.low - values).max()
        for cone in rows.cones:
            s = cone.offset + values[cone.own]
            beyond = max(beyond, np.linalg.norm(s[1:]) - s[0])
        return bool(beyond <= EQUALITY_TOLERANCE * max(1.0, float(np.abs(self._question.target).max())))

    def _spent(self) -> bool:
        seconds = self._limit.seconds
        late = seconds is not None and time.perf_counter() - self._start > seconds
        return late or self._solver.solved - self._before >= self._limit.solves

    def _push(self, bound: float, node: ChoiceTable | Box) -> None:
        """Pushes a node. Of equal bounds the one pushed last is popped first: depth first, until there is an
        incumbent."""
        if bound >= self._cutoff:
            self._leave(bound)
            return
        self._pushed += 1
        heapq.heappush(self._heap, (bound, -self._pushed, node))

    def _leave(self, bound: float) -> None:
        """Something is left unsolved: the result's bound may not be above its bound."""
        self._floor = min(self._floor, bound)
