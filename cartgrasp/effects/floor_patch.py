"""A region of the floor that rolls harder: a carpet, a mat, gravel.

Each wheel drags `coefficient * load` more, along its own rolling (`rolling_resistance.py`), while it is in a
rectangle of the world. Its share inside is the product of four edges, each smoothed over `EDGE`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array, rotation_planar
from .effect import Contribution, ForceEffect, Parameter, Situation, smooth_step
from .rolling_resistance import rolling_stiction, rolling_wrenches

EDGE = 0.005
"""m: a wheel's share inside goes from 12 % to 88 % within twice this."""


@final
@dataclass(frozen=True)
class FloorPatch(ForceEffect):
    """Extra rolling resistance between `x_min` and `x_max`, `y_min` and `y_max` (m, in {s})."""

    x_min: float = 0.0
    x_max: float = 0.0
    y_min: float = 0.0
    y_max: float = 0.0
    coefficient: float = 0.0

    name: ClassVar[str] = "floor_patch"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("x_min", "m", typical=1.0, estimated=False),
        Parameter("x_max", "m", typical=1.0, estimated=False),
        Parameter("y_min", "m", typical=1.0, estimated=False),
        Parameter("y_max", "m", typical=1.0, estimated=False),
        Parameter("coefficient", "-", typical=0.03, lower=0.0, upper=1.0),
    )
    signature: ClassVar[str] = "drag that comes and goes at places of the floor, whatever the direction"
    ordered: ClassVar[tuple[tuple[str, str], ...]] = (("x_min", "x_max"), ("y_min", "y_max"))

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        coefficient = parameters[..., 4]
        directions, by_velocity = rolling_wrenches(situation)
        loads, carried = situation.wheels.loads_with_map(situation.phi)
        share, by_place, by_edge = _share_inside(situation, parameters)
        pressing = share * loads
        by_share = -coefficient[..., None, None] * directions * loads[..., None, :]
        value = -coefficient[..., None] * np.einsum("...jn,...n->...j", directions, pressing)
        by_parameters = np.zeros((*value.shape, 5))
        by_parameters[..., :4] = by_share @ by_edge
        by_parameters[..., 4] = -np.einsum("...jn,...n->...j", directions, pressing)
        return Contribution(
            value=value,
            by_pose=by_share @ by_place,
            by_velocity=-coefficient[..., None, None] * np.einsum("...n,...nij->...ij", pressing, by_velocity),
            by_phi=(-coefficient[..., None, None] * directions * share[..., None, :]) @ carried,
            by_parameters=by_parameters,
        )

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array:
        share, _, _ = _share_inside(situation, parameters)
        return rolling_stiction(situation, parameters[..., 4, None] * share)


def _share_inside(situation: Situation, parameters: Array) -> tuple[Array, Array, Array]:
    """Share of each wheel inside (..., n), its partials by pose (..., n, 3) and by the edges (..., n, 4)."""
    pose = situation.pose_sb
    offset = situation.wheels.positions @ np.swapaxes(rotation_planar(pose[..., 2]), -1, -2)
    place = pose[..., None, :2] + offset
    edges = parameters[..., None, :4]
    sides = np.array([1.0, -1.0, 1.0, -1.0])
    into = sides * (place[..., [0, 0, 1, 1]] - edges)
    step, slope = smooth_step(into, EDGE)
    share = step.prod(axis=-1)
    others = np.stack([np.delete(step, k, axis=-1).prod(axis=-1) for k in range(4)], axis=-1)
    by_edge = -sides * others * slope
    along = -by_edge.reshape(*by_edge.shape[:-1], 2, 2).sum(axis=-1)
    swing = -along[..., 0] * offset[..., 1] + along[..., 1] * offset[..., 0]
    return share, np.concatenate([along, swing[..., None]], axis=-1), by_edge
