"""Rolling resistance: each wheel drags against its own rolling in proportion to its load (physics 16).

A fixed wheel rolls along {b}'s x, a caster along the velocity of its pivot. Loads are the static ones
(`wheels.py`), so the force depends on m, m dx and m dy too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import SMOOTHING_SPEED, Contribution, ForceEffect, Parameter, Situation


@final
@dataclass(frozen=True)
class RollingResistance(ForceEffect):
    """Drag `coefficient * load` at each wheel, independent of speed."""

    coefficient: float = 0.0

    name: ClassVar[str] = "rolling_resistance"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coefficient", "-", typical=0.02, lower=0.0, upper=1.0),
    )
    signature: ClassVar[str] = "a step of the forward force where the cart changes direction, flat in speed"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        directions, by_velocity = rolling_wrenches(situation)
        coefficient = parameters[..., 0]
        loads = situation.wheels.loads(situation.phi)
        by_load = -coefficient[..., None, None] * directions
        carried = (loads > 0)[..., None] * situation.wheels.load_map
        return Contribution(
            value=np.einsum("...ij,...j->...i", by_load, loads),
            by_velocity=-coefficient[..., None, None] * np.einsum("...n,...nij->...ij", loads, by_velocity),
            by_phi=by_load @ carried,
            by_parameters=-(directions @ loads[..., None]),
        )


def rolling_wrenches(situation: Situation) -> tuple[Array, Array]:
    """Wrench of a unit force along each wheel's rolling (..., 3, n), partials by velocity (..., n, 3, 3)."""
    wheels = situation.wheels
    x, y = wheels.positions.T
    n = len(x)
    # wheel velocity (2,) = at_wheel @ (u, w, r); its transpose carries a force at the wheel to {b}'s origin
    at_wheel = np.zeros((n, 2, 3))
    at_wheel[:, 0, 0], at_wheel[:, 0, 2] = 1.0, -y
    at_wheel[wheels.is_caster, 1, 1] = 1.0
    at_wheel[wheels.is_caster, 1, 2] = x[wheels.is_caster]
    speed = np.einsum("nij,...j->...ni", at_wheel, situation.velocity_b)
    norm = np.sqrt((speed**2).sum(axis=-1) + SMOOTHING_SPEED**2)[..., None]
    unit = speed / norm
    unit_by_speed = (np.eye(2) - unit[..., :, None] * unit[..., None, :]) / norm[..., None]
    directions = np.einsum("nij,...ni->...jn", at_wheel, unit)
    by_velocity = np.swapaxes(at_wheel, -1, -2) @ unit_by_speed @ at_wheel
    return directions, by_velocity
