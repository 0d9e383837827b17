"""All wrenches that an arm can give at a contact and a posture: `{F : rows @ F <= limits}`, F (6,) in {a}.

What an arm states about itself (box, friction by a number of sides) and what its joints bear, `|Jᵀ F + tau_0| <=
tau_max`, are all linear, so the set is a polytope; how far it goes in a direction is a linear program.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linprog

from cartgrasp.arms import Arm
from cartgrasp.checks import brief
from cartgrasp.contacts import WRENCH_NAMES
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from ..limits import limits_of

SOLVED, UNBOUNDED = 0, 3
"""Statuses of SciPy's `linprog`."""
MIN_PRICE_RATIO = 1e-9
"""Share of the largest price (dual value) below which a limit only touches and doesn't bind."""


class Farthest(NamedTuple):
    """The wrench (6,) that goes farthest in a direction, how far, in the direction's unit, and by which limits no
    farther."""

    distance: float
    wrench: Array
    limits: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class WrenchPolytope:
    """`names` (k,) tell the rows (k, 6) apart."""

    rows: Array
    limits: Array
    names: tuple[str, ...]

    @classmethod
    def of(cls, arm: Arm) -> WrenchPolytope:
        """The polytope of all limits that the arm states about itself; what has `sides` must have a number of them."""
        stated = limits_of(arm)
        if stated.cones:
            cone = stated.cones[0].name
            why = f"a polytope needs linear limits alone, not `{cone}`; set its `sides` to a number, or give rows"
            raise UsageError(f"arm {arm.name}: {why}")
        rows = np.vstack([np.eye(6), -np.eye(6), stated.rows, -stated.rows])
        limits = np.concatenate([stated.upper, -stated.lower, stated.limits, -stated.low_limits])
        names = (*stated.upper_names, *stated.lower_names, *stated.names, *stated.low_names)
        finite = np.isfinite(limits)
        return cls(rows[finite], limits[finite], tuple(compress(names, finite)))

    def support(self, direction: ArrayLike) -> Farthest:
        """max direction · F over the polytope: the other components may be whatever helps."""
        towards = np.asarray(direction, dtype=float)
        if towards.shape != (6,) or not np.isfinite(towards).all() or not towards.any():
            raise UsageError(f"wrench polytope: a direction is six finite numbers, not all 0: {towards.tolist()}")
        wrench, prices = maximizer(towards, self.rows, self.limits, what=_in_words(towards))
        binding = prices > MIN_PRICE_RATIO * prices.max()
        return Farthest(float(towards @ wrench), wrench, tuple(compress(self.names, binding)))

    def __repr__(self) -> str:
        return brief("WrenchPolytope", *(f"{name} {self._ends(i)}" for i, name in enumerate(WRENCH_NAMES)))

    def _ends(self, component: int) -> str:
        """How far a component can go each way, and by which limits no farther."""
        ends = []
        for sign in (-1.0, 1.0):
            try:
                end = self.support(sign * np.eye(6)[component])
                ends.append(f"{sign * end.distance + 0.0:.4g} ({', '.join(end.limits)})")
            except UsageError:
                ends.append(f"{sign * np.inf}")
        return " to ".join(ends)


def maximizer(
    gain: Array, rows: Array, limits: Array, equal: Array | None = None, what: str = "this"
) -> tuple[Array, Array]:
    """An x (n,) that maximizes `gain · x` subject to `rows @ x <= limits` (k,) and `equal @ x == 0`, and how much more
    each limit would give per unit (k,). `what` names the gain in the words of an error. Solved by HiGHS."""
    values = None if equal is None else np.zeros(len(equal))
    answer = linprog(-gain, rows, limits, equal, values, bounds=(None, None), method="highs-ds")
    if answer.status == UNBOUNDED:
        raise UsageError(f"nothing limits {what}; add limits of the arms or their joints")
    if answer.status != SOLVED or answer.x is None:
        raise UsageError(f"{what}: no wrench within all {len(limits)} limits was found: {answer.message}")
    return np.asarray(answer.x, dtype=float), -np.asarray(answer.ineqlin.marginals, dtype=float)


def _in_words(direction: Array) -> str:
    return " + ".join(f"{size:g} {name}" for size, name in zip(direction, WRENCH_NAMES, strict=True) if size)
