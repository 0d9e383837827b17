"""What hangs between a force/torque sensor and the hand's contact weighs, and is accelerated, in what is recorded.

A point mass m at c in {a}, on a hand that holds the cart fast, bears the specific force `s = a + r' z x c - r² c - g`
(`HandMotion`; g points down), so the sensor records the wrench on the cart and beside it `m (s, c x s)`. On a flat
floor the weight is in fz, tx and ty alone, the planar balances see the inertia.

A fast hold moves the mass as if it were the cart's own, there: who does not know the one or the other can tell the two
apart only when the hand takes another place.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import Array, skew
from .effect import HAND_AT_REST, Contribution, HandMotion, Parameter, SensorEffect

GRAVITY = 9.81
"""m/s²."""
AXIS_SKEWS = skew(np.eye(3))


@final
@dataclass(frozen=True)
class ToolInertia(SensorEffect):
    """A tool of `mass` (kg) at (`x`, `y`, `z`) (m) in {a} beyond the sensor. Its weight is in the recorded wrench: of a
    sensor that is tared at rest, add the tare, or heed that fz, tx and ty lack it."""

    mass: float = 0.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    name = "tool_inertia"
    parameters = (
        Parameter("mass", "kg", typical=1.0, lower=0.0),
        Parameter("x", "m", typical=0.05, grid=(0.0,)),
        Parameter("y", "m", typical=0.05, grid=(0.0,)),
        Parameter("z", "m", typical=0.05, estimated=False, grid=(0.0,)),
    )
    signature = "a force in proportion to the acceleration of one hand, wherever it holds"
    feels_motion = True

    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        return np.asarray(wrench_a + _borne(parameters, _specific_force(parameters, hand)))

    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        mass, place = parameters[..., :1], parameters[..., 1:]
        force = _specific_force(parameters, hand)
        value = np.asarray(wrench_a - _borne(parameters, force))
        by_parameters = np.zeros((*value.shape, 4))
        by_parameters[..., :3, 0], by_parameters[..., 3:, 0] = -force, -np.cross(place, force)
        by_place = np.moveaxis(_turning(hand), -1, 0)  # of the specific force
        for i, change in enumerate(by_place):
            by_parameters[..., :3, 1 + i] = -mass * change
            by_parameters[..., 3:, 1 + i] = -mass * (np.cross(np.eye(3)[i], force) + np.cross(place, change))
        return Contribution(value, by_parameters=by_parameters)


def _turning(hand: HandMotion) -> Array:
    """r' [z]x - r² of what turns, (..., 3, 3)."""
    rate, change = (np.asarray(part)[..., None, None] for part in (hand.yaw_rate, hand.yaw_acceleration))
    return np.asarray(change * AXIS_SKEWS[2] - rate**2 * np.diag([1.0, 1.0, 0.0]))


def _specific_force(parameters: Array, hand: HandMotion) -> Array:
    """(..., 3), m/s²."""
    turned = (_turning(hand) @ parameters[..., 1:, None])[..., 0]
    return np.asarray(hand.acceleration + turned + [0.0, 0.0, GRAVITY])


def _borne(parameters: Array, force: Array) -> Array:
    """The wrench (..., 6) in {a} that keeps the mass where it is."""
    place, force = np.broadcast_arrays(parameters[..., 1:], force)
    return np.asarray(parameters[..., :1] * np.concatenate([force, np.cross(place, force)], axis=-1))
