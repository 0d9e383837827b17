"""Rolling constraints: what fixed wheels and rails forbid.

In body components a constraint is a constant row, `Lambda_b @ (u, w, r) = 0`; in world components
`Lambda(theta) = Lambda_b @ R(theta)ᵀ`, which is (3) of the paper for an axle through {b}'s origin and
`[-sin, cos, a]` for an axle at x = a (physics.md). The free velocities `nu` span its null space:
`(u, w, r) = S_b @ nu`, with nu = (u, w, r), (u, r) or (u) for 0, 1 or 2 rows. Where the wheels roll at an angle to
{b}'s x, the first of them is their speed along that direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from .checks import MAX_DISTANCE, check_kind, number
from .errors import UsageError
from .frames import Array

VELOCITY_NAMES = {0: ("u", "w", "r"), 1: ("u", "r"), 2: ("u",)}


@dataclass(frozen=True)
class RollingConstraints:
    """No lateral slip at an axle at `axle_x` (m, in {b}; None: all wheels are casters), no rotation on a rail. The
    wheels roll at `angle` (rad) to {b}'s x, which the effect `wheel_misalignment` sets."""

    axle_x: float | None = 0.0
    no_rotation: bool = False
    angle: float = 0.0

    def __post_init__(self) -> None:
        if self.axle_x is None and self.no_rotation:
            raise UsageError("constraints: no_rotation needs no_lateral_slip beside it (a rail has both)")
        check_kind("constraints: no_rotation", self.no_rotation, bool, "write True or False")
        if self.axle_x is not None:
            number("constraints: axle_x", self.axle_x, -MAX_DISTANCE, MAX_DISTANCE, "give its x in {b}, m, or None")

    @property
    def n_rows(self) -> int:
        return int(self.axle_x is not None) + int(self.no_rotation)

    @property
    def n_free(self) -> int:
        return 3 - self.n_rows

    @property
    def velocity_names(self) -> tuple[str, ...]:
        return VELOCITY_NAMES[self.n_rows]

    @cached_property
    def basis_b(self) -> Array:
        """S_b, shape (3, n_free), constant, with `Lambda_b @ basis_b == 0`."""
        if self.axle_x is None:
            return np.eye(3)
        basis = np.array([[math.cos(self.angle), 0.0], [math.sin(self.angle), -self.axle_x], [0.0, 1.0]])
        return basis[:, :1] if self.no_rotation else basis

    @property
    def across_b(self) -> Array:
        """Unit vector (2,) across the wheels, to their left."""
        return np.array([-math.sin(self.angle), math.cos(self.angle)])

    @property
    def along_b(self) -> Array:
        """Shape (n_free, 3), with `along_b @ basis_b == 1`: takes a velocity to nu, its transpose a reduced wrench to
        one without force across the wheels."""
        if self.axle_x is None:
            return np.eye(3)
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        along = np.array([[cosine, sine, sine * self.axle_x], [0.0, 0.0, 1.0]])
        return along[:1] if self.no_rotation else along

    def free_velocity(self, velocity_b: ArrayLike) -> Array:
        """nu, shape (..., n_free), of a body velocity (u, w, r) that obeys the constraints."""
        return np.asarray(np.asarray(velocity_b, dtype=float) @ self.along_b.T)
