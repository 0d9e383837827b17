"""A Gaussian value, and the linear algebra that keeps its covariance sound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array


@dataclass(frozen=True)
class Gaussian:
    """Mean (..., n) and covariance (..., n, n)."""

    mean: Array
    covariance: Array

    @property
    def information(self) -> Array:
        """The covariance's inverse, (..., n, n)."""
        return np.asarray(np.linalg.inv(self.covariance), dtype=float)


def symmetric(matrix: Array) -> Array:
    return 0.5 * (matrix + np.swapaxes(matrix, -1, -2))


def normalised_square(difference: Array, covariance: Array) -> Array:
    """`dᵀ P⁻¹ d`, (...): NIS of an innovation, NEES of an error."""
    return np.asarray((difference * np.linalg.solve(covariance, difference[..., None])[..., 0]).sum(axis=-1))
