"""A program's rows as most solvers ask for them, `A x = b, G x <= h` with bounds and both sides of rows one below
another, and the multipliers of these as the program's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cartgrasp.frames import Array
from planning.quadratic_program import QuadraticProgram

Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class OneSided:
    """What is limited to one value is an equality; `equal`, `up` and `low` say where each row stands in (x, R x)."""

    A: Array
    b: Array
    G: Array
    h: Array
    equal: Places
    up: Places
    low: Places

    @classmethod
    def of(cls, program: QuadraticProgram) -> Self:
        """But for the cones."""
        rows, lower, upper = program.stacked[program.n :], program.lower, program.upper
        fixed = program.sense | (lower == upper)
        equal = np.flatnonzero(fixed)
        up, low = np.flatnonzero(~fixed & (upper < np.inf)), np.flatnonzero(~fixed & (lower > -np.inf))
        G, h = np.concatenate([rows[up], -rows[low]]), np.concatenate([upper[up], -lower[low]])
        return cls(rows[equal], upper[equal], G, h, equal, up, low)

    def multipliers(self, of_equal: Array, of_rest: Array, n: int) -> Array:
        """y (n,) of all bounds and rows; those of G x <= h below zero are rounding."""
        y, rest = np.zeros(n), np.maximum(of_rest, 0.0)
        y[self.equal] = of_equal
        y[self.up] += rest[: len(self.up)]
        y[self.low] -= rest[len(self.up) :]
        return y
