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

from ..limits import CartRows, RowCone
from ..quadratic_program import EQUALITY_TOLERANCE

TINY = 1e-12
"""N: a margin without a direction."""


@dataclass(frozen=True, eq=False)
class Tangents:
    """Rows with cones, and for each of these the direction u (j - 1,) of the half-space that stands for it."""

    rows: CartRows
    directions: tuple[Array, ...]

    @classmethod
    def touching(cls, rows: CartRows, values: Array) -> Tangents:
        """Half-spaces that touch the cones where the rows have such values (k,)."""
        return cls(rows, tuple(_unit(cone.offset[1:] + values[cone.own][1:]) for cone in rows.cones))

    def turned(self, values: Array, scale: float) -> Tangents | None:
        """Where a cone doesn't hold at values (k,) of the rows, within rounding of a wrench of such a scale: with those
        half-spaces turned. None where all hold."""
        found, holds = list(self.directions), True
        for i, cone in enumerate(self.rows.cones):
            s = cone.offset + values[cone.own]
            if np.linalg.norm(s[1:]) - s[0] > EQUALITY_TOLERANCE * scale:
                found[i], holds = _unit(s[1:]), False
        return None if holds else replace(self, directions=tuple(found))

    @cached_property
    def linear(self) -> CartRows:
        """Rows without cones, the half-spaces last."""
        rows, mix = self.rows, self._mixed
        kept = np.flatnonzero(self._is_plain)
        low = [np.dot(u, cone.offset[1:]) - cone.offset[0] for cone, u in self._cones]
        low_names, high_names = (tuple(names[i] for i in kept) for names in (rows.low_names, rows.high_names))
        names = tuple(cone.name for cone in rows.cones)
        return CartRows(
            of_sum=np.concatenate([rows.of_sum[kept], mix @ rows.of_sum]),
            of_arm=np.concatenate([rows.of_arm[:, kept], mix @ rows.of_arm], axis=1),
            low=np.concatenate([rows.low[kept], low]),
            high=np.concatenate([rows.high[kept], np.full(len(low), np.inf)]),
            low_names=low_names + names,
            high_names=high_names + names,
        )

    def multipliers(self, linear: Array) -> tuple[Array, list[Array]]:
        """Multipliers of the rows (k,) and of the cones, from those of the linear rows."""
        n_plain = int(self._is_plain.sum())
        of_rows = np.zeros(len(self.rows.low))
        of_rows[self._is_plain] = linear[:n_plain]
        own = zip(self._cones, linear[n_plain:].tolist(), strict=True)
        return of_rows, [-y * np.concatenate([[1.0], -u]) for (_, u), y in own]

    @property
    def _cones(self) -> list[tuple[RowCone, Array]]:
        return list(zip(self.rows.cones, self.directions, strict=True))

    @cached_property
    def _is_plain(self) -> np.ndarray:
        plain = np.ones(len(self.rows.low), dtype=bool)
        for cone in self.rows.cones:
            plain[cone.own] = False
        return plain

    @property
    def _mixed(self) -> Array:
        """How the rows (k,) add up to the half-spaces."""
        mix = np.zeros((len(self.rows.cones), len(self.rows.low)))
        for own, (cone, u) in zip(mix, self._cones, strict=True):
            own[cone.first], own[cone.first + 1 : cone.own.stop] = 1.0, -u
        return mix


def values_of(rows: CartRows, wrenches: Array, grasp_maps: Array) -> Array:
    """Values (k,) of rows for wrenches (6n,) of arms with spatial grasp maps (n, 6, 6)."""
    whole = grasp_maps.transpose(1, 0, 2).reshape(6, -1) @ wrenches
    return np.asarray(rows.of_sum @ whole + rows.of_arm.transpose(1, 0, 2).reshape(len(rows.low), -1) @ wrenches)


def _unit(direction: Array) -> Array:
    length = float(np.linalg.norm(direction))
    return direction / length if length > TINY else 0.0 * direction
