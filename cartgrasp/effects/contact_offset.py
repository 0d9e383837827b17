"""A hand that holds the cart beside where the robot believes.

A wrench (f, t) at the true contact p + d is recorded as if it acted at p. About p it is (f, t + d x f): with
d = (x, y, 0) the moments are greater by (y fz, -x fz, x fy - y fx), and forces are as recorded.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import Array, skew
from .effect import HAND_AT_REST, Contribution, HandMotion, Parameter, SensorEffect

LEVERS = skew(np.eye(3)[:2])
"""What a metre along x, and along y, makes of a force: moments (2, 3, 3)."""


@final
@dataclass(frozen=True)
class ContactOffset(SensorEffect):
    """The hand holds at (`x`, `y`) (m, in {a}) of the recorded contact point. `x` acts on forces across the cart, of
    which noise may be most where wheels bear them, and that noise is in the moment, too: it is taken as it is told."""

    x: float = 0.0
    y: float = 0.0

    name = "contact_offset"
    parameters = (
        Parameter("x", "m", typical=0.03, estimated=False, grid=(0.0,)),
        Parameter("y", "m", typical=0.03),
    )
    signature = "a yaw moment in proportion to one hand's force"

    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        return np.asarray((_shifted(-parameters) @ wrench_a[..., None])[..., 0])

    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        shift = _shifted(parameters)
        value = np.asarray((shift @ wrench_a[..., None])[..., 0])
        by_parameters = np.zeros((*value.shape, 2))
        for i, lever in enumerate(LEVERS):
            by_parameters[..., 3:, i] = wrench_a[..., :3] @ lever.T
        return Contribution(value, by_memory=shift, by_parameters=by_parameters)


def _shifted(offset: Array) -> Array:
    """What takes a wrench at a contact that is off by (..., 2) to the believed one, shape (..., 6, 6)."""
    shift = np.zeros((*offset.shape[:-1], 6, 6))
    shift[...] = np.eye(6)
    shift[..., 3:, :3] += np.einsum("...i,ijk->...jk", offset, LEVERS)
    return shift
