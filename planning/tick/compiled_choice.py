"""Choice among single points as one compiled search (kernels/choice.py), with its proof.

Segments, and more choices than a table holds, are for contact_choice.py; so is a search that met a program without a
proven answer.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np

from cartgrasp.frames import Array

from ..contacts.contact_bounds import MAX_TABLE_CHOICES, Candidates
from ..contacts.contact_cases import GAP_TOLERANCE
from ..contacts.contact_choice import Choice, SearchLimit
from ..contacts.switching_cost import Switching
from ..objectives import Cost
from .compiled_allocation import CompiledAllocation, Point, Progress, Tables

PROGRAMS_PER_CLOCK_CHECK = 16  # programs between two looks at the clock
NO_NUMBERS = np.zeros(0)


@dataclass(eq=False)
class CompiledChoice:
    """The search over one set of candidates; `last` is the choice of the last call, which the next begins with."""

    candidates: Candidates
    _allocation: CompiledAllocation
    _allowed: Array
    _tables: Tables
    _progress: Progress
    last: int = -1
    _switching: Switching | None = None
    _shown: tuple[int, Array] = (-1, NO_NUMBERS)

    @classmethod
    def of(cls, candidates: Candidates, allocation: CompiledAllocation) -> Self | None:
        """None where candidates aren't single points, or too many."""
        if candidates.has_segments or candidates.count > MAX_TABLE_CHOICES:
            return None
        allowed = np.where(candidates.allowed((), range(candidates.n_arms)), -np.inf, np.inf).ravel()
        n, points = 6 * candidates.n_arms, candidates.vertices
        starts, weights = np.array(candidates.starts, dtype=np.int64), np.zeros(n)
        tables = (points, starts, weights, NO_NUMBERS, np.zeros((4, n)), np.zeros(len(points)), np.zeros(len(allowed)))
        return cls(candidates, allocation, allowed, tables, (np.zeros(2), np.zeros(3, np.int64)))

    def run(self, wrench: Point, cost: Cost, limit: SearchLimit, switching: Switching | None = None) -> Choice | None:
        """The allocation then holds the answer at the contacts chosen. None if a program had no proven answer."""
        if switching is not self._switching:
            self._take(switching)
        values, counts = self._progress
        bounds = self._tables[-1]
        bounds[:], self._tables[2][:] = self._allowed, cost.weights
        begin = self.last if self.last >= 0 else int(self._allowed.argmin())
        values[:], counts[:] = (np.inf, -np.inf), (-1, begin, 0)
        if self._allowed[begin] == np.inf:
            counts[1] = -1
        gap = GAP_TOLERANCE if limit.gap is None else limit.gap
        if not self._search(wrench, limit, gap):
            return None
        best, left = values.tolist()
        chosen, following, solved = counts.tolist()
        self.last = chosen
        bound = min(best, left if following >= 0 else np.inf)
        contacts = None if chosen < 0 else self._contacts(chosen)
        complete = following < 0 or (chosen >= 0 and best - bound <= gap * max(1.0, abs(best)))
        paid = 0.0 if contacts is None or switching is None else switching.at(contacts, contacts)
        return Choice(contacts, best, bound, solved, complete, paid)

    def _take(self, switching: Switching | None) -> None:
        charges = NO_NUMBERS if switching is None else switching.charges
        self._switching, self._tables = switching, (*self._tables[:3], charges, *self._tables[4:])

    def _search(self, wrench: Point, limit: SearchLimit, gap: float) -> bool:
        start, most = time.perf_counter(), limit.solves
        if limit.seconds is None:
            return self._allocation.search(wrench, self._tables, self._progress, (most, gap))
        while True:
            up_to = min(most, int(self._progress[1][2]) + PROGRAMS_PER_CLOCK_CHECK)
            if not self._allocation.search(wrench, self._tables, self._progress, (up_to, gap)):
                return False
            if self._progress[1][2] < up_to or up_to == most or time.perf_counter() - start > limit.seconds:
                return True

    def _contacts(self, choice: int) -> Array:
        """The same object as long as the choice is the same."""
        if choice != self._shown[0]:
            starts = self.candidates.starts
            picked = np.unravel_index(choice, [stop - start for start, stop in pairwise(starts)])
            contacts = self.candidates.vertices[[s + int(i) for s, i in zip(starts, picked, strict=False)]]
            contacts.setflags(write=False)
            self._shown = choice, contacts
        return self._shown[1]
