"""Wheels: where the cart touches the floor, and how its weight spreads over them.

Loads are those of equal springs under a rigid cart at rest, the least-norm solution of the three equilibrium
equations about the wheels' centre: affine in the wheel's position and linear in (m, m dx, m dy). Wheels in
one line carry the whole weight too; the moment that they can't balance is left to the hands on the handle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from .errors import UsageError
from .frames import Array

GRAVITY = 9.81
FIXED, CASTER = "fixed", "caster"


@dataclass(frozen=True)
class Wheel:
    """A fixed wheel, which rolls along {b}'s x, or a caster, which trails its pivot by `trail`; (x, y) in {b}, m."""

    kind: str
    x: float
    y: float
    trail: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in (FIXED, CASTER):
            raise UsageError(f"wheels: kind: {self.kind!r} is neither {FIXED!r} nor {CASTER!r}")
        if not np.isfinite([self.x, self.y, self.trail]).all():
            raise UsageError("wheels: a position or trail is not finite")
        if self.trail < 0:
            raise UsageError(f"wheels: trail: {self.trail:g} m is negative")


@dataclass(frozen=True)
class WheelSet:
    """The wheels of a cart."""

    wheels: tuple[Wheel, ...]

    @classmethod
    def of(cls, wheels: Sequence[Wheel], rolls_along_x: bool) -> WheelSet:
        """The listed wheels, or one that carries the whole weight at {b}'s origin where none is listed."""
        return cls(tuple(wheels) or (Wheel(FIXED if rolls_along_x else CASTER, 0.0, 0.0),))

    @cached_property
    def positions(self) -> Array:
        """Shape (n, 2), in {b}."""
        return np.array([[w.x, w.y] for w in self.wheels])

    @cached_property
    def spans_floor(self) -> bool:
        """Whether the wheels stand in more than one line, so that they carry a moment about any."""
        return bool(np.linalg.matrix_rank(self.positions - self.positions.mean(axis=0), tol=1e-9) == 2)

    @cached_property
    def is_caster(self) -> np.ndarray:
        return np.array([w.kind == CASTER for w in self.wheels])

    @cached_property
    def rolling_map(self) -> Array:
        """Shape (n, 2, 3): velocity (2,) with which each wheel rolls, from (u, w, r); a fixed one rolls along x only.
        Its transpose carries a force at the wheel to {b}'s origin."""
        x, y = self.positions.T
        rolling = np.zeros((len(x), 2, 3))
        rolling[:, 0, 0], rolling[:, 0, 2] = 1.0, -y
        rolling[self.is_caster, 1, 1] = 1.0
        rolling[self.is_caster, 1, 2] = x[self.is_caster]
        return rolling

    @cached_property
    def load_map(self) -> Array:
        """Shape (n, 4): `loads = load_map @ phi`, N, while every wheel stands on the floor."""
        return self._load_map(np.ones(len(self.wheels), dtype=bool))

    def loads(self, phi: ArrayLike) -> Array:
        """Static load of each wheel, shape (..., n), N."""
        return self.loads_with_map(phi)[0]

    def loads_with_map(self, phi: ArrayLike) -> tuple[Array, Array]:
        """Loads (..., n), and their partials by phi, (..., n, 4) or (n, 4). A wheel can't pull on the floor:
        one that would stands off it, and the others carry all."""
        phi = np.asarray(phi, dtype=float)
        load_map, loads = self.load_map, phi @ self.load_map.T
        standing = np.ones(loads.shape, dtype=bool)
        while (pulling := standing & (loads < 0)).any():
            standing &= ~pulling
            patterns, which = np.unique(standing.reshape(-1, loads.shape[-1]), axis=0, return_inverse=True)
            load_map = np.stack([self._load_map(pattern) for pattern in patterns])[which.ravel()]
            load_map = load_map.reshape(*loads.shape, phi.shape[-1])
            loads = (load_map @ phi[..., None])[..., 0]
        return loads, load_map

    def _load_map(self, standing: np.ndarray) -> Array:
        """The load map when only some wheels stand on the floor."""
        load_map = np.zeros((len(self.wheels), 4))
        if standing.any():
            positions = self.positions[standing]
            centre = positions.mean(axis=0)
            equilibrium = np.vstack([np.ones(len(positions)), (positions - centre).T])
            about_centre = np.hstack([np.eye(3), np.zeros((3, 1))])
            about_centre[1:, 0] = -centre
            load_map[standing] = GRAVITY * np.linalg.pinv(equilibrium, rcond=1e-9) @ about_centre
        return load_map
