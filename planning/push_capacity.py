"""How much of a desired push several arms can give together, each within its wrench polytope.

    max s   subject to   Sᵀ sum(G_i F_i) = s Sᵀ wrench_b,   F_i in the polytope of arm i.

s >= 1 can be done, with s - 1 to spare; s < 1 can't. S is the basis of the cart's free velocities.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from cartgrasp.contacts import grasp_map_planar
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from .linear_program import maximizer
from .wrench_polytope import WrenchPolytope


class Grasp(NamedTuple):
    """Where an arm holds (3,) in {b}, what it can give there, and the yaw of {a} in {b}."""

    contact: tuple[float, float, float]
    polytope: WrenchPolytope
    yaw: float = 0.0


@dataclass(frozen=True, eq=False)
class PushCapacity:
    """`multiple` of the desired wrench, and the wrenches (6,) in {a}, by arm, that give it."""

    multiple: float
    wrenches: Mapping[str, Array]


def push_capacity(cart: CartModel, grasps: Mapping[str, Grasp], wrench_b: ArrayLike) -> PushCapacity:
    """The largest multiple of `wrench_b`, (fx, fy, tau) on the cart."""
    wrench = np.asarray(wrench_b, dtype=float)
    if wrench.shape != (3,) or not np.isfinite(wrench).all() or not (cart.basis_b.T @ wrench).any():
        raise UsageError(f"wrench_b: {wrench.tolist()} is no finite wrench (fx, fy, tau) that moves this cart")
    maps = np.hstack([grasp_map_planar(grasp.contact, grasp.yaw) for grasp in grasps.values()])
    rows = block_diag(*(grasp.polytope.rows for grasp in grasps.values()))
    found = maximizer(
        np.append(np.zeros(maps.shape[1]), 1.0),
        np.hstack([rows, np.zeros((len(rows), 1))]),
        np.concatenate([grasp.polytope.limits for grasp in grasps.values()]),
        cart.basis_b.T @ np.hstack([maps, -wrench[:, None]]),
        "this push",
    )
    return PushCapacity(float(found[-1]), dict(zip(grasps, found[:-1].reshape(-1, 6), strict=True)))
