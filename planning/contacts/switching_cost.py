"""What it costs that a hand holds elsewhere than at the last plan, so that hands don't move for next to nothing.

An arm that moves pays a constant, wherever it goes. That adds to the bound of each of its options, so the choice of
contacts stays exact; of a segment, the place now held becomes one more option, a point, which is free. An arm without a
choice (its contact is given, or its only one) pays nothing, nor does one of which nothing is known to be held.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self, final

import numpy as np

from cartgrasp.checks import check_known, number
from cartgrasp.frames import Array

from .contact_bounds import Candidates

SAME_CONTACT_DISTANCE = 1e-9  # m
MAX_SWITCHING_COST = 1e9  # gaps are relative: beside more than this they would say nothing of efforts


@dataclass(frozen=True, eq=False)
class Switching:
    """The cost of switching: an arm at any contact but its row of `stay` (n, 3) pays its entry of `costs` (n,). A row
    of `stay` is NaN where the arm can't stay."""

    candidates: Candidates
    stay: Array
    costs: Array

    @classmethod
    def of(cls, candidates: Candidates, held: Array, costs: Array) -> Self:
        """Adds contacts `held` (n, 3) as options of their own where they lie on a segment; a row is NaN where nothing
        is held. An arm with one contact only counts as holding there."""
        stay, ends, starts = held.copy(), candidates.ends, candidates.starts
        costs = np.where(np.isnan(held).any(axis=1), 0.0, costs)
        for arm, point in enumerate(held):
            own = ends[starts[arm] : starts[arm + 1]]
            is_point = (own[:, 0] == own[:, 1]).all(axis=1)
            near = _away(own, point) <= SAME_CONTACT_DISTANCE
            if len(own) == 1 and is_point[0]:
                stay[arm] = own[0, 0]
            elif (near & is_point).any():
                stay[arm] = own[(near & is_point).argmax(), 0]
            elif not near.any():
                stay[arm] = np.nan
            elif costs[arm] > 0:
                candidates = candidates.with_point(arm, point)
        return cls(candidates, stay, costs)

    def at(self, low: Array, high: Array) -> float:
        """What it costs to hold between `low` and `high`, (n, 3) each, but not where one stays."""
        return float(self.costs @ ((low != self.stay) | (high != self.stay)).any(axis=1))

    @cached_property
    def charges(self) -> Array:
        """The switching cost of each option, (O,)."""
        arms = np.repeat(np.arange(len(self.costs)), np.diff(self.candidates.starts))
        moves = (self.candidates.ends != self.stay[arms, None]).any(axis=(1, 2))
        return np.asarray(self.costs[arms] * moves)

    @property
    def seed(self) -> Array | None:
        """Where all arms stay, if all can."""
        return None if np.isnan(self.stay).any() else self.stay


@final
class SwitchingCost:
    """The cost of switching for every arm, or by arm's name (zero for those left out), in the objective's unit."""

    def __init__(self, cost: float | Mapping[str, float], names: Sequence[str]) -> None:
        by_arm = dict(cost) if isinstance(cost, Mapping) else dict.fromkeys(names, cost)
        check_known("switching_cost", by_arm, names)
        for one in by_arm.values():
            number("switching_cost", one, 0.0, MAX_SWITCHING_COST, "give one for all arms, or one by arm")
        self._costs = np.array([by_arm.get(name, 0.0) for name in names], dtype=float)
        self.is_any = bool(self._costs.any())
        self._last: tuple[Candidates, Array, Switching] | None = None

    def over(self, candidates: Candidates, held: Array) -> Switching | None:
        """None where nothing is to pay; that of the last call where nothing has changed."""
        if not self.is_any:
            return None
        last = self._last
        if last is None or candidates is not last[0] or not (held is last[1] or np.array_equal(held, last[1])):
            self._last = last = candidates, held, Switching.of(candidates, held, self._costs)
        return last[2]


def _away(ends: Array, point: Array) -> Array:
    """Distances (k,) of a point from segments (k, 2, 3)."""
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    square = np.einsum("ki,ki->k", along, along)
    share = np.einsum("ki,ki->k", point - start, along) / np.where(square > 0, square, 1.0)
    return np.asarray(np.linalg.norm(start + np.clip(share, 0.0, 1.0)[:, None] * along - point, axis=1))
