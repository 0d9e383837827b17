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
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("coefficient", "-", typical=0.02, lower=0.0, upper=1.0),)
    signature: ClassVar[str] = "a step of the forward force where the cart changes direction, flat in speed"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        directions, by_velocity = rolling_wrenches(situation)
        coefficient = parameters[..., 0]
        loads, carried = situation.wheels.loads_with_map(situation.phi)
        by_load = -coefficient[..., None, None] * directions
        return Contribution(
            value=(by_load @ loads[..., None])[..., 0],
            by_velocity=-coefficient[..., None, None] * (loads[..., None, None] * by_velocity).sum(axis=-3),
            by_phi=by_load @ carried,
            by_parameters=-(directions @ loads[..., None]),
        )

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array:
        return rolling_stiction(situation, parameters[..., 0, None])


def rolling_stiction(situation: Situation, coefficients: Array) -> Array:
    """`ForceEffect.stiction` (..., 3, 2 n) of wheels with rolling resistance `coefficients` (..., n)."""
    unit, _ = smooth_rolling(situation)
    still = 1.0 - (unit**2).sum(axis=-1)
    level = coefficients * situation.wheels.loads(situation.phi) * still
    columns = level[..., None, None] * situation.wheels.rolling_map
    return np.swapaxes(columns.reshape(*columns.shape[:-3], -1, 3), -1, -2)


def smooth_rolling(situation: Situation) -> tuple[Array, Array]:
    """Direction of each wheel's rolling (..., n, 2), below 1 at standstill; smoothed speed (..., n, 1)."""
    speed = (situation.wheels.rolling_map @ situation.velocity_b[..., None, :, None])[..., 0]
    norm = np.sqrt((speed**2).sum(axis=-1) + SMOOTHING_SPEED**2)[..., None]
    return speed / norm, norm


def rolling_wrenches(situation: Situation) -> tuple[Array, Array]:
    """Wrench of a unit force along each wheel's rolling (..., 3, n), partials by velocity (..., n, 3, 3)."""
    rolling = situation.wheels.rolling_map
    unit, norm = smooth_rolling(situation)
    unit_by_speed = (np.eye(2) - unit[..., :, None] * unit[..., None, :]) / norm[..., None]
    transposed = np.swapaxes(rolling, -1, -2)
    directions = np.swapaxes((transposed @ unit[..., None])[..., 0], -1, -2)
    return directions, transposed @ unit_by_speed @ rolling
