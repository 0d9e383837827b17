"""Splines through a log's poses and velocities, and what those have beside a motion that is known already."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.sparse import csr_array

from cartgrasp.frames import Array

from .splines import SplineFit


@dataclass(frozen=True, eq=False)
class PoseFits:
    """Fits (3) of a tracked frame's pose in {s}, and what makes values and rates at times (n,) of coefficients."""

    fits: tuple[SplineFit, ...]
    time: Array
    value: csr_array
    rate: csr_array

    def beside(self, known: Array) -> tuple[Array, Array, Array]:
        """Poses and rates (n, 3) that keep to what is known of the rates, (n, 3), but for what is smooth; and the
        penalties (3,) that make it so."""
        moved = self._moved(known)
        own = [fit.beside(self.time, one) for fit, one in zip(self.fits, _by_axis(moved, known), strict=True)]
        pose, rate = self._summed([coefficients for coefficients, _ in own], moved, known)
        return pose, rate, np.array([penalty for _, penalty in own])

    def noise_beside(self, known: Array, penalties: Array, generator: np.random.Generator) -> tuple[Array, Array]:
        """Errors (n, 3) of such poses and rates that the sensors' noise makes, and errors of what is known."""
        moved = self._moved(known)
        parts = zip(self.fits, _by_axis(moved, known), penalties, strict=True)
        return self._summed([fit.noise_beside(self.time, own, one, generator) for fit, own, one in parts], moved, known)

    def _moved(self, rate: Array) -> Array:
        return np.asarray(cumulative_trapezoid(rate, self.time, axis=0, initial=0))

    def _summed(self, coefficients: list[Array], moved: Array, rate: Array) -> tuple[Array, Array]:
        own = np.column_stack(coefficients)
        return moved + self.value @ own, rate + self.rate @ own


def _by_axis(value: Array, rate: Array) -> Iterator[tuple[Array, Array]]:
    return zip(value.T, rate.T, strict=True)
