"""A force/torque sensor whose axes are turned about z from where they are believed to be.

The true wrench F in {a} is recorded in the turned axes, `Rz(angle)ᵀ F`, for force and moment alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import Array
from .effect import HAND_AT_REST, Contribution, HandMotion, Parameter, SensorEffect

QUARTER_TURN = np.kron(np.eye(2), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
Z_PROJECTION = np.diag([0.0, 0.0, 1.0, 0.0, 0.0, 1.0])


@final
@dataclass(frozen=True)
class ForceMisalignment(SensorEffect):
    """The sensor is turned by `angle` (rad, about z of {a}) against its believed pose."""

    angle: float = 0.0

    name = "force_misalignment"
    parameters = (Parameter("angle", "rad", typical=0.05, lower=-np.pi, upper=np.pi),)
    signature = "a side force in proportion to the forward force, and the other way round"

    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        return np.asarray((_turn(-parameters[..., 0]) @ wrench_a[..., None])[..., 0])

    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        turn = _turn(parameters[..., 0])
        value = np.asarray((turn @ wrench_a[..., None])[..., 0])
        return Contribution(value, by_memory=turn, by_parameters=QUARTER_TURN @ value[..., None])


def _turn(angle: Array) -> Array:
    """Rz(angle) on force and moment, shape (..., 6, 6)."""
    cosine, sine = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    return np.asarray(Z_PROJECTION + cosine * (np.eye(6) - Z_PROJECTION) + sine * QUARTER_TURN)
