"""How much of a desired push several arms can give together, each within its wrench polytope.

    max s   subject to   Sᵀ sum(G_i F_i) = s Sᵀ wrench_b,   F_i in the polytope of arm i.

s >= 1 can be done, with s - 1 to spare; s < 1 can't. S is the basis of the cart's free velocities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from cartgrasp.arms import Arm
from cartgrasp.contacts import grasp_map_planar
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..allocation.allocation_template import AllocationTemplate
from .wrench_polytope import WrenchPolytope, maximizer


@dataclass(frozen=True, eq=False)
class PushCapacity:
    """`multiple` of the desired wrench, and the wrenches (6,) in {a}, by arm, that give it."""

    multiple: float
    wrenches: Mapping[str, Array]


def push_capacity(cart: CartModel, arms: Sequence[Arm], wrench_b: ArrayLike) -> PushCapacity:
    """The largest multiple of `wrench_b`, (fx, fy, tau) on the cart, with each arm at its first contact."""
    arms, wrench = AllocationTemplate.of(cart, arms).arms, np.asarray(wrench_b, dtype=float)
    if wrench.shape != (3,) or not np.isfinite(wrench).all() or not (cart.basis_b.T @ wrench).any():
        raise UsageError(f"wrench_b: {wrench.tolist()} is no finite wrench (fx, fy, tau) that moves this cart")
    maps = np.hstack([grasp_map_planar(arm.contacts.first, arm.yaw) for arm in arms])
    polytopes = [WrenchPolytope.of(arm) for arm in arms]
    rows = block_diag(*(polytope.rows for polytope in polytopes))
    found, _ = maximizer(
        np.append(np.zeros(maps.shape[1]), 1.0),
        np.hstack([rows, np.zeros((len(rows), 1))]),
        np.concatenate([polytope.limits for polytope in polytopes]),
        cart.basis_b.T @ np.hstack([maps, -wrench[:, None]]),
        "this push",
    )
    names = [arm.name for arm in arms]
    return PushCapacity(float(found[-1]), dict(zip(names, found[:-1].reshape(-1, 6), strict=True)))
