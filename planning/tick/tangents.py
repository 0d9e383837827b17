"""Margins' cones as half-spaces that touch them, for what is compiled.

A cone `‖s(F)‖ <= s0(F)` lies in every half-space `uᵀ s(F) <= s0(F)` with ‖u‖ = 1. So an optimum with half-spaces in the
place of cones, at which the cones hold, is the optimum with the cones; and where half-spaces leave nothing, cones leave
nothing. Where a cone doesn't hold, its half-space is turned to touch it there (Kelley, 1960), and so on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array

from ..limits import CartRows
from ..quadratic_program import EQUALITY_TOLERANCE

MIN_MARGIN = 1e-12
"""N: a margin without a direction."""


@dataclass(frozen=True, eq=False)
class Tangents:
    """Rows with c cones, and for each of these the direction u (c, j - 1) of the half-space that stands for it."""

    rows: CartRows
    directions: Array

    @classmethod
    def touching(cls, rows: CartRows, values: Array) -> Tangents:
        """Half-spaces that touch the cones where the rows have such values (k,)."""
        s = _in_cones(rows, values)[:, 1:]
        return cls(rows, _units(s, np.sqrt(np.square(s).sum(axis=1))))

    def turned(self, values: Array, scale: float) -> Tangents | None:
        """Where a cone doesn't hold at values (k,) of the rows, within rounding of a wrench of such a scale: with those
        half-spaces turned. None where all hold."""
        s = _in_cones(self.rows, values)
        lengths = np.sqrt(np.square(s[:, 1:]).sum(axis=1))
        beyond = lengths - s[:, 0] > EQUALITY_TOLERANCE * scale
        if not beyond.any():
            return None
        return replace(self, directions=np.where(beyond[:, None], _units(s[:, 1:], lengths), self.directions))

    def curvature(self, values: Array, linear: Array) -> Array:
        """How the cones bend in what hands give in sum, (6, 6), where the rows have values (k,), weighed with the
        multipliers of the linear rows: what a half-space lacks of a cone in the second order."""
        rows = self.rows
        s, lengthwise = _in_cones(rows, values)[:, 1:], rows.of_sum[rows.n_plain :].reshape(*self._mix.shape, 6)[:, 1:]
        lengths = np.sqrt(np.square(s).sum(axis=1))
        weights = np.divide(-linear[rows.n_plain :], lengths, out=np.zeros(len(s)), where=lengths > MIN_MARGIN)
        along = np.einsum("ci,cij->cj", _units(s, lengths), lengthwise)
        bent = np.einsum("c,cij,cik->jk", weights, lengthwise, lengthwise)
        return np.asarray(bent - np.einsum("c,cj,ck->jk", weights, along, along))

    @cached_property
    def linear(self) -> CartRows:
        """Rows without cones, the half-spaces last. What hands give counts in sum to a cone's rows."""
        rows, mix, n = self.rows, self._mix, self.rows.n_plain
        c, offsets = len(mix), rows.cone_offsets
        half_spaces = (mix[:, None] @ rows.of_sum[n:].reshape(*mix.shape, 6))[:, 0]
        return CartRows(
            of_sum=np.concatenate([rows.of_sum[:n], half_spaces]),
            of_arm=np.concatenate([rows.of_arm[:, :n], np.zeros((len(rows.of_arm), c, 6))], axis=1),
            low=np.concatenate([rows.low[:n], -(mix * offsets).sum(axis=1)]),
            high=np.concatenate([rows.high[:n], np.full(c, np.inf)]),
            low_names=rows.low_names[:n] + rows.cone_names,
            high_names=rows.high_names[:n] + rows.cone_names,
            units=rows.units and rows.units[:n] + ("N",) * c,
        )

    def multipliers(self, linear: Array) -> tuple[Array, list[Array]]:
        """Multipliers of the rows (k,) and of the cones, from those of the linear rows."""
        n, of_rows = self.rows.n_plain, np.zeros(len(self.rows.low))
        of_rows[:n] = linear[:n]
        return of_rows, list(-linear[n:, None] * self._mix)

    @cached_property
    def _mix(self) -> Array:
        """How a cone's rows add up to the half-space, (c, j)."""
        return np.column_stack([np.ones(len(self.directions)), -self.directions])


def values_of(rows: CartRows, wrenches: Array, grasp_maps: Array) -> Array:
    """Values (k,) of rows for wrenches (6n,) of arms with spatial grasp maps (n, 6, 6)."""
    values, n = rows.of_sum @ (in_sum(grasp_maps) @ wrenches), rows.n_plain
    values[:n] += rows.of_arm[:, :n].transpose(1, 0, 2).reshape(n, len(wrenches)) @ wrenches
    return np.asarray(values)


def in_sum(grasp_maps: Array) -> Array:
    """What wrenches (6n,) of arms with spatial grasp maps (n, 6, 6) are in sum, as a matrix (6, 6n)."""
    return np.asarray(grasp_maps.transpose(1, 0, 2).reshape(6, -1))


def _in_cones(rows: CartRows, values: Array) -> Array:
    """What lies in the cones (c, j), for values (k,) of the rows."""
    offsets = rows.cone_offsets
    return np.asarray(offsets + values[rows.n_plain :].reshape(offsets.shape))


def _units(directions: Array, lengths: Array) -> Array:
    """Rows (c, j) of such lengths (c,) as unit rows, 0 where there is none."""
    return directions * np.divide(1.0, lengths, out=np.zeros(len(lengths)), where=lengths > MIN_MARGIN)[:, None]
