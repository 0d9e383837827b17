"""Rolling constraints: what fixed wheels and rails forbid.

In body components a constraint is a constant row, `Lambda_b @ (u, w, r) = 0`; in world components
`Lambda(theta) = Lambda_b @ R(theta)ᵀ`, which is (3) of the paper for an axle through {b}'s origin and
`[-sin, cos, a]` for an axle at x = a (physics 2). The free velocities `nu` span its null space:
`(u, w, r) = S_b @ nu`, with nu = (u, w, r), (u, r) or (u) for 0, 1 or 2 rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from .errors import UsageError
from .frames import Array, body_to_world

VELOCITY_NAMES = {0: ("u", "w", "r"), 1: ("u", "r"), 2: ("u",)}


@dataclass(frozen=True)
class RollingConstraints:
    """No lateral slip at an axle at `axle_x` (m, in {b}; None: all wheels are casters), no rotation on a rail."""

    axle_x: float | None = 0.0
    no_rotation: bool = False

    def __post_init__(self) -> None:
        if self.axle_x is None and self.no_rotation:
            raise UsageError("constraints: no_rotation needs no_lateral_slip beside it (a rail has both)")
        if self.axle_x is not None and not np.isfinite(self.axle_x):
            raise UsageError(f"constraints: no_lateral_slip: x = {self.axle_x} is not finite")

    @property
    def n_rows(self) -> int:
        return int(self.axle_x is not None) + int(self.no_rotation)

    @property
    def n_free(self) -> int:
        return 3 - self.n_rows

    @property
    def velocity_names(self) -> tuple[str, ...]:
        return VELOCITY_NAMES[self.n_rows]

    @property
    def rows_b(self) -> Array:
        """Lambda_b, shape (n_rows, 3)."""
        rows = [] if self.axle_x is None else [[0.0, 1.0, self.axle_x]]
        if self.no_rotation:
            rows.append([0.0, 0.0, 1.0])
        return np.array(rows).reshape(len(rows), 3)

    @cached_property
    def basis_b(self) -> Array:
        """S_b, shape (3, n_free), constant, with `rows_b @ basis_b == 0`."""
        if self.axle_x is None:
            return np.eye(3)
        basis = np.array([[1.0, 0.0], [0.0, -self.axle_x], [0.0, 1.0]])
        return basis[:, :1] if self.no_rotation else basis

    def rows_s(self, theta: ArrayLike) -> Array:
        """Lambda(theta) of (3) in world components, shape (..., n_rows, 3)."""
        return self.rows_b @ np.swapaxes(body_to_world(theta), -1, -2)

    def rows_s_rate(self, theta: ArrayLike, yaw_rate: ArrayLike) -> Array:
        """d Lambda / dt in world components, shape (..., n_rows, 3)."""
        quarter_turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
        rate = np.swapaxes(body_to_world(theta) @ quarter_turn, -1, -2)
        return np.asarray(self.rows_b @ rate * np.asarray(yaw_rate, dtype=float)[..., None, None])

    def basis_s(self, theta: ArrayLike) -> Array:
        """S(theta) with `qd = S(theta) @ nu`, shape (..., 3, n_free)."""
        return body_to_world(theta) @ self.basis_b

    def free_velocity(self, velocity_b: ArrayLike) -> Array:
        """nu, shape (..., n_free), of a body velocity (u, w, r) that obeys the constraints."""
        picked = {0: [0, 1, 2], 1: [0, 2], 2: [0]}[self.n_rows]
        return np.asarray(velocity_b, dtype=float)[..., picked]
