"""Stribeck friction: a peak of drag near standstill that fades as the wheels get going.

    F = -breakaway * v / |v| * exp(-(|v| / speed)²),    v = (u, w)

The sign is smoothed like that of every Coulomb force (`effect.py`), so exactly at rest the force is 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import SMOOTHING_SPEED, Contribution, ForceEffect, Parameter, Situation


@final
@dataclass(frozen=True)
class StribeckFriction(ForceEffect):
    """Drag of at most `breakaway` (N) at {b}'s origin, gone at some times `speed` (m/s)."""

    breakaway: float = 0.0
    speed: float = 0.05

    name: ClassVar[str] = "stribeck_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("breakaway", "N", typical=5.0, lower=0.0),
        Parameter("speed", "m/s", typical=0.05, lower=0.001, upper=10.0, absent=0.05, estimated=False),
    )
    signature: ClassVar[str] = "a peak of the forward force near standstill, gone at speed"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        breakaway, speed = parameters[..., 0, None], parameters[..., 1, None]
        velocity = situation.velocity_b[..., :2]
        squared = (velocity**2).sum(axis=-1, keepdims=True)
        norm = np.sqrt(squared + SMOOTHING_SPEED**2)
        unit = velocity / norm
        fade = np.exp(-squared / speed**2)
        unit_by_velocity = (np.eye(2) - unit[..., :, None] * unit[..., None, :]) / norm[..., None]
        fade_by_velocity = -2 * velocity / speed**2 * fade
        slope = fade[..., None] * unit_by_velocity + unit[..., :, None] * fade_by_velocity[..., None, :]

        force = -breakaway * fade * unit
        value = np.zeros((*force.shape[:-1], 3))
        by_velocity = np.zeros((*value.shape, 3))
        by_parameters = np.zeros((*value.shape, 2))
        value[..., :2] = force
        by_velocity[..., :2, :2] = -breakaway[..., None] * slope
        by_parameters[..., :2, 0] = -fade * unit
        by_parameters[..., :2, 1] = force * 2 * squared / speed**3
        return Contribution(value, by_velocity=by_velocity, by_parameters=by_parameters)

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array:
        squared = (situation.velocity_b[..., :2] ** 2).sum(axis=-1)
        still = SMOOTHING_SPEED**2 / (squared + SMOOTHING_SPEED**2)
        level = parameters[..., 0] * np.exp(-squared / parameters[..., 1] ** 2) * still
        return np.asarray(level[..., None, None] * np.eye(3)[:, :2])
