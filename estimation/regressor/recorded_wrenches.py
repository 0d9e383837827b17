"""The sensed wrenches of the moments that are tracked, as one table."""

from __future__ import annotations

import math
from typing import Self

import numpy as np

from cartgrasp.frames import Array

from ..kernels.filtered_row import drop
from ..kernels.wrench_limits import HELD
from ..shallow import shallow
from ..wrench_sensing import SensedWrench

ROOM = 64


def row_of(time: float, sensed: SensedWrench, parameters: Array) -> Array:
    """(1 + f + f² + f p + p,): the time of a sample, the reduced wrench, its noise, its partials by the parameters, and
    the parameters that it was worked out at."""
    return np.concatenate([[time], sensed.value, sensed.covariance.ravel(), sensed.by_parameters.ravel(), parameters])


class RecordedWrenches:
    """A row for each moment; its time is NaN where there is no wrench, and it stays for as long as it may be held."""

    def __init__(self, f: int, p: int) -> None:
        self._f, self._rows, self._n = f, np.zeros((ROOM, 1 + f + f * f + f * p + p)), 0

    @property
    def rows(self) -> Array:
        return self._rows[: self._n]

    @property
    def room(self) -> Array:
        """All rows, for kernels that fill them, which then are `filled`."""
        return self._rows

    def filled(self, moments: int) -> None:
        """So many are in the rows by now."""
        self._n = moments

    def start(self) -> None:
        """Anew, with a moment."""
        self._n, self._rows[0, 0] = 1, math.nan

    def next(self, time: float) -> None:
        """A later moment."""
        self.make_room(self._n + 1)
        rows, i = self._rows, self._n
        rows[i] = rows[i - 1]
        if not time - rows[i, 0] < HELD:
            rows[i, 0] = math.nan
        self._n = i + 1

    def note(self, time: float, sensed: SensedWrench, parameters: Array) -> None:
        """At the last moment."""
        self._rows[self._n - 1] = row_of(time, sensed, parameters)

    def before(self) -> tuple[Array, Array] | None:
        """Value (f,) and noise (f, f) at the last moment but one."""
        row, f = self._rows[max(self._n - 2, 0)], self._f
        if self._n < 2 or math.isnan(row[0]):
            return None
        return row[1 : 1 + f], row[1 + f : 1 + f + f * f].reshape(f, f)

    def drop(self, k: int) -> None:
        """The first k moments."""
        drop(self.rows, k)
        self._n -= k

    def copy(self) -> Self:
        other = shallow(self)
        other._rows = np.empty_like(self._rows)
        other._rows[: self._n] = self.rows
        return other

    def make_room(self, moments: int) -> None:
        """For so many."""
        while len(self._rows) < moments:
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
