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

from .checks import MAX_DISTANCE, number
from .errors import UsageError
from .frames import Array

GRAVITY = 9.81
FIXED, CASTER = "fixed", "caster"
DEFAULT_TRAIL = 0.045


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
        for what, low in (("x", -MAX_DISTANCE), ("y", -MAX_DISTANCE), ("trail", 0.0)):
            number(f"wheels: {what}", getattr(self, what), low, MAX_DISTANCE, "give m")


@dataclass(frozen=True)
class WheelSet:
    """The wheels of a cart."""

    wheels: tuple[Wheel, ...]
    are_listed: bool = True

    @classmethod
    def of(cls, wheels: Sequence[Wheel], rolls_along_x: bool) -> WheelSet:
        """The listed wheels, or one that carries the whole weight at {b}'s origin where none is listed."""
        if wheels:
            return cls(tuple(wheels))
        return cls((Wheel(FIXED if rolls_along_x else CASTER, 0.0, 0.0),), are_listed=False)

    @cached_property
    def positions(self) -> Array:
        """Shape (n, 2), in {b}."""
        return np.array([[w.x, w.y] for w in self.wheels])

    @cached_property
    def spans_floor(self) -> bool:
        """Whether the wheels stand in more than one line, so that they carry a moment about any."""
        return bool(np.linalg.matrix_rank(self.positions - self.positions.mean(axis=0), tol=1e-9) == 2)

    @property
    def lists_casters(self) -> bool:
        return self.are_listed and bool(self.is_caster.any())

    @cached_property
    def is_caster(self) -> np.ndarray:
        return np.array([w.kind == CASTER for w in self.wheels])

    @cached_property
    def pivots(self) -> Array:
        """Shape (k, 3): x, y and trail of each caster; one at {b}'s origin where none is listed."""
        casters = [w for w in self.wheels if w.kind == CASTER] or [Wheel(CASTER, 0.0, 0.0)]
        return np.array([[w.x, w.y, w.trail or DEFAULT_TRAIL] for w in casters])

    @cached_property
    def load_map(self) -> Array:
        """Shape (n, 4): `loads = load_map @ phi`, N, while every wheel stands on the floor."""
        return self.loads_with_map(np.zeros(4))[1]

    def loads(self, phi: ArrayLike) -> Array:
        """Static load of each wheel, shape (..., n), N."""
        return self.loads_with_map(phi)[0]

    def loads_with_map(self, phi: ArrayLike) -> tuple[Array, Array]:
        """Loads (..., n), and their partials by phi, (..., n, 4). A wheel can't pull on the floor: one that would
        stands off it, and the others carry all."""
        from .kernels import wheel_loads

        phi, n = np.asarray(phi, dtype=float), len(self.wheels)
        loads, load_map = np.empty((*phi.shape[:-1], n)), np.empty((*phi.shape[:-1], n, 4))
        phis = np.ascontiguousarray(phi.reshape(-1, 4))
        found = loads.reshape(-1, n), load_map.reshape(-1, n, 4), np.zeros((len(phis), n))
        wheel_loads.stacked_loads(self.positions, GRAVITY, phis, found)
        return loads, load_map
