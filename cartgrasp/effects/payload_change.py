"""Mass put on, or taken off, at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from ..frames import Array
from .effect import Contribution, InertiaEffect, Parameter


@final
@dataclass(frozen=True)
class PayloadChange(InertiaEffect):
    """A point mass `mass` (kg, negative: taken off) at (x, y) in {b} (m) from `time` (s) on.

    The mass joins at the cart's velocity, so velocities do not jump.
    """

    time: float = 0.0
    mass: float = 0.0
    x: float = 0.0
    y: float = 0.0

    name: ClassVar[str] = "payload_change"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("time", "s", typical=10.0, estimated=False),
        Parameter("mass", "kg", typical=5.0),
        Parameter("x", "m", typical=0.2),
        Parameter("y", "m", typical=0.2),
    )
    signature: ClassVar[str] = "mass and CoM differ before and after an instant"

    def phi_change(self, time: Any, parameters: Array) -> Contribution:
        since, mass, x, y = np.moveaxis(parameters, -1, 0)
        present = (np.asarray(time) >= since).astype(float)
        shape = np.stack(np.broadcast_arrays(np.ones_like(x), x, y, x**2 + y**2), axis=-1)
        value = (present * mass)[..., None] * shape
        by_parameters = np.zeros((*value.shape, 4))
        by_parameters[..., 1] = present[..., None] * shape
        by_parameters[..., 1, 2] = by_parameters[..., 2, 3] = present * mass
        by_parameters[..., 3, 2] = 2 * present * mass * x
        by_parameters[..., 3, 3] = 2 * present * mass * y
        return Contribution(value, by_parameters=by_parameters)
