"""Effects without a kernel: subclasses of `ForceEffect` and `InertiaEffect` from outside this library. Their
contributions, which they work out in numpy, are where the kernels' sums begin."""

from __future__ import annotations

import numpy as np

from .checks import check_kind
from .compiled_dynamics import StatePoint
from .effects.effect import Contribution, ForceEffect, InertiaEffect, Situation
from .errors import UsageError
from .frames import Array
from .kernels.situation import Parts
from .kernels.workspace import N_PHI
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
    checked = cart.structure.setdefault("foreign shapes", set())  # by how many axes are in front
    is_new = len(lead) not in checked
    for change, where in changes:
        part = change.phi_change(time, parameters[..., where])
        if is_new:
            check_shapes(f"{change.key}.phi_change", part, (N_PHI, 0, where.stop - where.start), lead)
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
        n_memory, n_own = own.stop - own.start, where.stop - where.start
        part = effect.wrench_b(*given)
        if is_new:
            check_shapes(f"{effect.key}.wrench_b", part, (wrench.value.shape[-1], n_memory, n_own), lead)
        _add(wrench, part, (slice(None), own, where))
        if cart.drives(effect):
            part = effect.memory_rate(*given)
            if is_new:
                check_shapes(f"{effect.key}.memory_rate", part, (n_memory, n_memory, n_own), lead)
            _add(rate, part, (own, own, where))
    checked.add(len(lead))
    return block


def check_shapes(what: str, part: Contribution, sizes: tuple[int, int, int], lead: tuple[int, ...]) -> None:
    """Refuses a contribution that numpy would stretch to what it is added to: `sizes` of its value, of the memory and
    of the parameters, behind axes that may be `lead`."""
    check_kind(what, part, Contribution, "return Contribution(value, by_velocity=…, by_parameters=…)")
    rows, n_memory, n_parameters = sizes
    columns = {"by_pose": 3, "by_velocity": 3, "by_phi": N_PHI, "by_memory": n_memory, "by_parameters": n_parameters}
    wanted = {"value": (rows,)} | {name: (rows, count) for name, count in columns.items()}
    for name, shape in wanted.items():
        given = getattr(part, name)
        if given is not None and not _fits(np.shape(given), shape, lead):
            or_more = f" or {(*lead, *shape)}" if lead else ""
            raise UsageError(f"{what}: {name} has shape {np.shape(given)}, but {shape}{or_more} is needed")


def _fits(shape: tuple[int, ...], wanted: tuple[int, ...], lead: tuple[int, ...]) -> bool:
    """Whether it is wanted, behind no other axes than broadcast to `lead`."""
    front = len(shape) - len(wanted)
    ahead = zip(reversed(shape[:front]), reversed(lead), strict=False)
    return 0 <= front <= len(lead) and shape[front:] == wanted and all(n in (1, most) for n, most in ahead)


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
