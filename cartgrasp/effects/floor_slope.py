"""A floor that is not level: gravity pulls at the CoM, so it also turns the cart.

With the height `h = grade · (x, y)` of the floor, the potential `m g h(CoM)` gives `-m g grade` in {s}, so

    f_b = -m g R(theta)ᵀ grade,    tau = m dx (f_b/m)_y - m dy (f_b/m)_x,

linear in m, m dx and m dy. The floor's angle is small: 1 - cos of it is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from ..wheels import GRAVITY
from .effect import Contribution, ForceEffect, Parameter, Situation


@final
@dataclass(frozen=True)
class FloorSlope(ForceEffect):
    """Rise over run along the world's x and y."""

    grade_x: float = 0.0
    grade_y: float = 0.0

    name: ClassVar[str] = "floor_slope"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("grade_x", "-", typical=0.01, lower=-1.0, upper=1.0),
        Parameter("grade_y", "-", typical=0.01, lower=-1.0, upper=1.0),
    )
    signature: ClassVar[str] = "a force that depends on heading, also at rest, and keeps its sign when the motion turns"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        theta = situation.pose_sb[..., 2]
        cosine, sine = np.cos(theta), np.sin(theta)
        grade_x, grade_y = parameters[..., 0], parameters[..., 1]
        pull_x = -GRAVITY * (cosine * grade_x + sine * grade_y)
        pull_y = -GRAVITY * (cosine * grade_y - sine * grade_x)
        by_phi = _per_phi(pull_x, pull_y)
        lead = np.broadcast_shapes(by_phi.shape[:-2], situation.phi.shape[:-1])
        by_pose, by_parameters = np.zeros((*lead, 3, 3)), np.zeros((*lead, 3, 2))
        by_pose[..., 2] = _wrench(pull_y, -pull_x, situation.phi)
        by_parameters[..., 0] = _wrench(-GRAVITY * cosine, GRAVITY * sine, situation.phi)
        by_parameters[..., 1] = _wrench(-GRAVITY * sine, -GRAVITY * cosine, situation.phi)
        value = _wrench(pull_x, pull_y, situation.phi)
        return Contribution(value, by_pose=by_pose, by_phi=by_phi, by_parameters=by_parameters)


def _per_phi(pull_x: Array, pull_y: Array) -> Array:
    """Partials by phi (..., 3, 4) of the wrench of a pull per mass, in {b}, at the CoM."""
    partial = np.zeros((*pull_x.shape, 3, 4))
    partial[..., 0, 0], partial[..., 1, 0] = pull_x, pull_y
    partial[..., 2, 1], partial[..., 2, 2] = pull_y, -pull_x
    return partial


def _wrench(pull_x: Array, pull_y: Array, phi: Array) -> Array:
    return np.asarray((_per_phi(pull_x, pull_y) @ phi[..., None])[..., 0])
