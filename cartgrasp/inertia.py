"""Planar inertial parameters.

`phi = (m, m dx, m dy, J)` with `J = I + m (dx² + dy²)` enters the dynamics linearly (paper, II.B). It is physical
when `m > 0` and `J m > |m d|²`: the planar pseudo-inertia is positive definite (physics.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .checks import MAX_DISTANCE, number, numbers
from .errors import UsageError
from .frames import Array, components

PHI_NAMES = ("m", "m_dx", "m_dy", "J")
N_PHI = len(PHI_NAMES)
Number = TypeVar("Number", float, Array)


def phi_from_physical(mass: ArrayLike, com_x: ArrayLike, com_y: ArrayLike, inertia: ArrayLike) -> Array:
    """phi, shape (..., 4), from mass, CoM in {b} and yaw inertia about the CoM."""
    given = (np.asarray(v, dtype=float) for v in (mass, com_x, com_y, inertia))
    return np.stack(np.broadcast_arrays(*_phi(*given)), axis=-1)


def physical_from_phi(phi: ArrayLike) -> Array:
    """(mass, com_x, com_y, inertia about the CoM), shape (..., 4)."""
    return np.stack(_physical(*components(np.asarray(phi, dtype=float))), axis=-1)


def physical_jacobian(phi: ArrayLike) -> Array:
    """Partials of `physical_from_phi`, shape (..., 4, 4)."""
    mass, first_x, first_y, _ = components(np.asarray(phi, dtype=float))
    jacobian = np.zeros((*np.shape(mass), 4, 4))
    jacobian[..., 0, 0] = 1.0
    jacobian[..., 1, 0], jacobian[..., 1, 1] = -first_x / mass**2, 1 / mass
    jacobian[..., 2, 0], jacobian[..., 2, 2] = -first_y / mass**2, 1 / mass
    jacobian[..., 3, 0] = (first_x**2 + first_y**2) / mass**2
    jacobian[..., 3, 1], jacobian[..., 3, 2] = -2 * first_x / mass, -2 * first_y / mass
    jacobian[..., 3, 3] = 1.0
    return jacobian


@dataclass(frozen=True)
class Inertia:
    """Mass (kg), CoM in {b} (m) and yaw inertia about the CoM (kg m²) of the cart with its load."""

    mass: float
    com: tuple[float, float]
    about_com: float

    def __post_init__(self) -> None:
        number("mass", self.mass, -math.inf, math.inf, "give kg")
        com = numbers("com", self.com, "(x, y) in {b}, m", -MAX_DISTANCE, MAX_DISTANCE)
        object.__setattr__(self, "com", com)  # a list or an array would compare and hash otherwise
        number("inertia", self.about_com, -math.inf, math.inf, "give kg m²")
        self._check_physical()

    def _check_physical(self) -> None:
        if not all(map(math.isfinite, (self.mass, *self.com, self.about_com))):
            raise UsageError(f"inertia: {self} has a value that is not finite")
        if self.mass <= 0:
            raise UsageError(f"mass: {self.mass:g} kg is not positive")
        if self.about_com <= 0:
            raise UsageError(
                f"inertia: {self.about_com:g} kg m² about the CoM is not positive (J m > |m d|² must hold)"
            )

    @classmethod
    def from_phi(cls, phi: ArrayLike) -> Inertia:
        values: list[float] = np.asarray(phi, dtype=float).tolist()
        if values[0] <= 0:
            raise UsageError(f"mass: {values[0]:g} kg is not positive")
        mass, com_x, com_y, about_com = _physical(*values)
        found = object.__new__(cls)  # a fit may pass through bodies that nobody would write
        found.__dict__.update(mass=mass, com=(com_x, com_y), about_com=about_com)
        found._check_physical()
        return found

    @property
    def phi(self) -> Array:
        return np.array(_phi(self.mass, *self.com, self.about_com))


def _phi(mass: Number, com_x: Number, com_y: Number, inertia: Number) -> tuple[Number, Number, Number, Number]:
    return mass, mass * com_x, mass * com_y, inertia + mass * (com_x * com_x + com_y * com_y)


def _physical(mass: Number, first_x: Number, first_y: Number, J: Number) -> tuple[Number, Number, Number, Number]:
    return mass, first_x / mass, first_y / mass, J - (first_x * first_x + first_y * first_y) / mass
