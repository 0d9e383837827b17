"""Effects without a kernel: subclasses of `ForceEffect` and `InertiaEffect` from outside this library. Their
contributions, which they work out in numpy, are where the kernels' sums begin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .compiled_dynamics import StatePoint
from .effects.effect import Contribution, ForceEffect, InertiaEffect, Situation
from .frames import Array
from .kernels.situation import Parts
from .kernels.workspace import N_PHI

if TYPE_CHECKING:
    from .model import CartModel

ForeignForce = tuple[ForceEffect, slice, slice]
ForeignInertia = tuple[InertiaEffect, slice]


def foreign_sums(
    cart: CartModel, point: StatePoint, forces: tuple[ForeignForce, ...], changes: tuple[ForeignInertia, ...]
) -> Array:
    """What they add at a point, a block (..., size) of `kernels.workspace.Sums`."""
    dynamics, (state, time, parameters) = cart.dynamics, point
    lead = np.broadcast_shapes(state.shape[:-1], np.shape(time), parameters.shape[:-1])
    block = np.zeros((*lead, dynamics.n_sums))
    phi, phi_by_parameters, wrench, rate, _ = dynamics.parts(block)
    for change, where in changes:
        part = change.phi_change(time, parameters[..., where])
        phi += part.value
        if part.by_parameters is not None:
            phi_by_parameters[..., where] += part.by_parameters
    pose, velocity = state[..., :3], state[..., cart.velocity_slice] @ cart.basis_b.T
    is_all = len(changes) == len(cart.inertia_effects)  # of what changes phi; else kernels add the rest
    whole = parameters[..., :N_PHI] + phi if is_all else dynamics.sums(point, block)[..., :N_PHI]
    situation = Situation(time, pose, velocity, whole, cart.wheel_set)
    memory = state[..., cart.memory_slice]
    for effect, where, own in forces:
        given = situation, memory[..., own], parameters[..., where]
        _add(wrench, effect.wrench_b(*given), (slice(None), own, where))
        if cart.drives(effect):
            _add(rate, effect.memory_rate(*given), (own, own, where))
    return block


def _add(parts: Parts, part: Contribution, where: tuple[slice, slice, slice]) -> None:
    """`where`: its rows, and its columns in the partials by memory and by parameters."""
    rows, memory, parameters = where
    everywhere = slice(None)
    parts.value[..., rows] += part.value
    for total, partial, columns in (
        (parts.by_pose, part.by_pose, everywhere),
        (parts.by_velocity, part.by_velocity, everywhere),
        (parts.by_phi, part.by_phi, everywhere),
        (parts.by_memory, part.by_memory, memory),
        (parts.by_parameters, part.by_parameters, parameters),
    ):
        if partial is not None:
            total[..., rows, columns] += partial
