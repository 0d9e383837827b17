"""`CartModel`: inertia, rolling constraints and effects, and how the cart moves.

The state is `(x, y, theta | nu | memory)`, the parameters are `(phi | effects' values)`. With S the basis of the free
velocities, the reduced dynamics are (physics 4)

    Sᵀ M_b S nu' = Sᵀ (wrench_b + effects - bias),    pose' = R(theta) S nu.

They are in the body frame, where S is constant. Every function broadcasts over leading axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .constraints import RollingConstraints
from .effects import Effect, ForceEffect, InertiaEffect, SensorEffect
from .effects.effect import Contribution, Situation
from .errors import UsageError
from .frames import Array, body_to_world
from .inertia import PHI_NAMES, Inertia
from .rigid_body import bias_b, mass_matrix_b, regressor_b
from .wheels import Wheel, WheelSet

if TYPE_CHECKING:
    import os
    from pathlib import Path

N_PHI = len(PHI_NAMES)
STRUCTURE = ("wheel_set", "basis_b", "parameter_names", "memory_names", "state_names", "velocity_slice", "memory_slice")
"""Cached properties that do not depend on numbers."""
N_POSE = 3


@dataclass(frozen=True)
class StateRate:
    """Rate of the state (..., n) and its partials by state (n), planar wrench in {b} (3) and parameters (p)."""

    value: Array
    by_state: Array
    by_wrench: Array
    by_parameters: Array


@dataclass(frozen=True)
class CartModel:
    """A cart: what is pushed, and what acts on it. Frozen; `with_...` returns another."""

    inertia: Inertia
    constraints: RollingConstraints = RollingConstraints()
    effects: tuple[Effect, ...] = ()
    wheels: tuple[Wheel, ...] = ()
    com_height: float | None = None
    name: str = "cart"
    source: str = field(default="", repr=False, compare=False)

    def __post_init__(self) -> None:
        keys = [effect.key for effect in self.effects]
        for key in keys:
            if keys.count(key) > 1:
                raise UsageError(f"effects: {key} stands twice; give each its own label")

    # --- structure -------------------------------------------------------------------------------------------

    def with_effect(self, effect: Effect) -> CartModel:
        """The cart with one more effect."""
        return replace(self, effects=(*self.effects, effect))

    def without_effect(self, key: str) -> CartModel:
        """The cart without the effect called `key` (`name` or `name.label`)."""
        left = tuple(effect for effect in self.effects if effect.key != key)
        if len(left) == len(self.effects):
            known = ", ".join(effect.key for effect in self.effects) or "none"
            raise UsageError(f"effects: this cart has no {key}; it has {known}")
        return replace(self, effects=left)

    def with_inertia(self, inertia: Inertia) -> CartModel:
        return replace(self, inertia=inertia)

    def with_parameters(self, parameters: ArrayLike) -> CartModel:
        """The same structure with other numbers (p,)."""
        parameters = np.asarray(parameters, dtype=float)
        effects = tuple(e.with_values(parameters[s]) for e, s in zip(self.effects, self._slices, strict=True))
        other = replace(self, inertia=Inertia.from_phi(parameters[:N_PHI]), effects=effects)
        structure = {k: v for k, v in self.__dict__.items() if k in STRUCTURE}
        other.__dict__.update(structure)
        return other

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes `cart.yaml`, with the comments and order of the file it was read from."""
        from .cart_file import save_cart

        return save_cart(self, path)

    @cached_property
    def force_effects(self) -> tuple[tuple[ForceEffect, slice, slice], ...]:
        """Each with its slices of the parameters and of the memory."""
        found, start = [], 0
        for effect, where in zip(self.effects, self._slices, strict=True):
            if isinstance(effect, ForceEffect):
                size = len(effect.memory_names(self.wheel_set))
                found.append((effect, where, slice(start, start + size)))
                start += size
        return tuple(found)

    @cached_property
    def inertia_effects(self) -> tuple[tuple[InertiaEffect, slice], ...]:
        pairs = zip(self.effects, self._slices, strict=True)
        return tuple((e, s) for e, s in pairs if isinstance(e, InertiaEffect))

    @cached_property
    def sensor_effects(self) -> tuple[tuple[SensorEffect, slice], ...]:
        pairs = zip(self.effects, self._slices, strict=True)
        return tuple((e, s) for e, s in pairs if isinstance(e, SensorEffect))

    @cached_property
    def wheel_set(self) -> WheelSet:
        return WheelSet.of(self.wheels, rolls_along_x=self.constraints.n_rows > 0)

    @cached_property
    def basis_b(self) -> Array:
        return self.constraints.basis_b

    @cached_property
    def parameters(self) -> Array:
        """(phi | effects' values), shape (p,)."""
        return np.concatenate([self.inertia.phi, *(effect.values for effect in self.effects)])

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        return PHI_NAMES + tuple(key for effect in self.effects for key in effect.keys)

    @cached_property
    def memory_names(self) -> tuple[str, ...]:
        return tuple(n for effect, _, _ in self.force_effects for n in effect.memory_names(self.wheel_set))

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        return ("x", "y", "theta", *self.constraints.velocity_names, *self.memory_names)

    @cached_property
    def velocity_slice(self) -> slice:
        return slice(N_POSE, N_POSE + self.constraints.n_free)

    @cached_property
    def memory_slice(self) -> slice:
        return slice(self.velocity_slice.stop, len(self.state_names))

    @cached_property
    def _slices(self) -> tuple[slice, ...]:
        slices, start = [], N_PHI
        for effect in self.effects:
            slices.append(slice(start, start + len(effect.parameters)))
            start += len(effect.parameters)
        return tuple(slices)

    def state(self, pose_sb: ArrayLike = (0.0, 0.0, 0.0), velocity: ArrayLike | None = None) -> Array:
        """A state (n,) at a pose and free velocity (0 unless given), with effects' first memory."""
        velocity = np.zeros(self.constraints.n_free) if velocity is None else velocity
        memory: Sequence[Array] = [e.first_memory(self.wheel_set) for e, _, _ in self.force_effects]
        return np.concatenate([np.asarray(pose_sb, float), np.asarray(velocity, float), *memory])

    # --- motion ----------------------------------------------------------------------------------------------

    def rate(
        self,
        state: Array,
        wrench_b: Array,
        parameters: Array | None = None,
        time: Any = 0.0,
        trust: Array | None = None,
    ) -> StateRate:
        """Forward dynamics with analytic partials. Where `trust` (..., n_free) of 0 to 1 is given, the accelerations
        in the partials by phi are scaled by it: an estimator learns only from those that a wrench above its noise made.
        """
        parameters = self.parameters if parameters is None else parameters
        situation, changes = self._situation(state, parameters, time)
        basis = self.basis_b
        wrench = _Wrench(self, situation, state, parameters)
        bias, bias_by_velocity = bias_b(situation.velocity_b, situation.phi)
        inverse = np.linalg.inv(basis.T @ mass_matrix_b(situation.phi) @ basis)
        acceleration = _apply(inverse @ basis.T, wrench_b + wrench.value - bias)
        reach = inverse @ basis.T
        seen = acceleration if trust is None else trust * acceleration
        rigid = regressor_b(situation.velocity_b, seen @ basis.T)

        lead = np.broadcast_shapes(acceleration.shape[:-1], parameters.shape[:-1])
        n, nv, nm = state.shape[-1], self.velocity_slice, self.memory_slice
        value = np.zeros((*lead, n))
        by_state = np.zeros((*lead, n, n))
        by_wrench = np.zeros((*lead, n, 3))
        by_parameters = np.zeros((*lead, n, parameters.shape[-1]))

        rotation = body_to_world(situation.pose_sb[..., 2])
        value[..., :3] = _apply(rotation, situation.velocity_b)
        by_state[..., 0, 2], by_state[..., 1, 2] = -value[..., 1], value[..., 0]
        by_state[..., :3, nv] = rotation @ basis

        value[..., nv] = acceleration
        by_state[..., nv, :3] = reach @ wrench.by_pose
        by_state[..., nv, nv] = reach @ (wrench.by_velocity - bias_by_velocity) @ basis
        by_state[..., nv, nm] = reach @ wrench.by_memory
        by_wrench[..., nv, :] = reach
        by_phi = reach @ (wrench.by_phi - rigid)
        by_parameters[..., nv, :] = reach @ wrench.by_parameters
        by_parameters[..., nv, :N_PHI] += by_phi
        for where, change in changes:
            if change.by_parameters is not None:
                by_parameters[..., nv, where] += by_phi @ change.by_parameters
        self._memory_rate(situation, state, parameters, (value, by_state, by_parameters))
        return StateRate(value, by_state, by_wrench, by_parameters)

    def state_rate(self, state: Array, wrench_b: Array, parameters: Array | None = None, time: Any = 0.0) -> Array:
        """Forward dynamics without partials: the rate of the state, (..., n)."""
        parameters = self.parameters if parameters is None else parameters
        situation, _ = self._situation(state, parameters, time)
        basis, phi = self.basis_b, situation.phi
        push = wrench_b + self._effects(situation, state, parameters) - bias_b(situation.velocity_b, phi)[0]
        inverse = np.linalg.inv(basis.T @ mass_matrix_b(phi) @ basis)
        value = np.zeros((*np.broadcast_shapes(push.shape[:-1], state.shape[:-1]), state.shape[-1]))
        value[..., :3] = _apply(body_to_world(situation.pose_sb[..., 2]), situation.velocity_b)
        value[..., self.velocity_slice] = _apply(inverse @ basis.T, push)
        for effect, where, own in self.force_effects:
            if own.stop > own.start:
                rows = slice(self.memory_slice.start + own.start, self.memory_slice.start + own.stop)
                value[..., rows] = effect.memory_rate(situation, state[..., rows], parameters[..., where]).value
        return value

    def required_wrench(
        self, state: Array, acceleration: Array, parameters: Array | None = None, time: Any = 0.0
    ) -> Array:
        """Inverse dynamics: the reduced wrench `Sᵀ wrench_b`, (..., n_free), that gives nu' = `acceleration`."""
        parameters = self.parameters if parameters is None else parameters
        situation, _ = self._situation(state, parameters, time)
        rigid = regressor_b(situation.velocity_b, acceleration @ self.basis_b.T)
        effects = self._effects(situation, state, parameters)
        return (_apply(rigid, situation.phi) - effects) @ self.basis_b

    def regressor(self, velocity: Array, acceleration: Array) -> Array:
        """Y, (..., n_free, 4), with `Sᵀ (wrench_b + effects) = Y @ phi`, from nu and nu'."""
        return self.basis_b.T @ regressor_b(velocity @ self.basis_b.T, acceleration @ self.basis_b.T)

    def effect_wrench(self, state: Array, parameters: Array | None = None, time: Any = 0.0) -> Array:
        """Sum of the force effects on the cart, (..., 3), in {b}."""
        parameters = self.parameters if parameters is None else parameters
        situation, _ = self._situation(state, parameters, time)
        return self._effects(situation, state, parameters)

    def stiction(self, state: Array, parameters: Array, time: Any = 0.0) -> Array:
        """Wrenches (3, k), in {b}, that Coulomb effects may give near standstill beside their modelled ones."""
        situation, _ = self._situation(state, parameters, time)
        memory = state[..., self.memory_slice]
        found = [e.stiction(situation, memory[..., own], parameters[..., s]) for e, s, own in self.force_effects]
        return np.concatenate([np.zeros((3, 0)), *(f for f in found if f is not None)], axis=-1)

    def settled_memory(self, state: Array, parameters: Array, time: Any = 0.0) -> Array:
        """Where the effects' memories (..., k) come to rest when the motion goes on as it is."""
        situation, _ = self._situation(state, parameters, time)
        memory = state[..., self.memory_slice]
        settled = [effect.settled_memory(situation, memory[..., own]) for effect, _, own in self.force_effects]
        return np.concatenate([memory[..., :0], *settled], axis=-1)

    def planar_wrench(self, reduced: Array) -> Array:
        """A wrench (..., 3) in {b} without side force whose effective rows `Sᵀ wrench_b` are `reduced`."""
        wrench = np.zeros((*reduced.shape[:-1], 3))
        wrench[..., {0: [0, 1, 2], 1: [0, 2], 2: [0]}[self.constraints.n_rows]] = reduced
        return wrench

    def phi_at(self, time: Any, parameters: Array | None = None) -> Array:
        """phi with what inertia effects add at a time, (..., 4)."""
        parameters = self.parameters if parameters is None else parameters
        phi = parameters[..., :N_PHI]
        for effect, where in self.inertia_effects:
            phi = phi + effect.phi_change(time, parameters[..., where]).value
        return phi

    # --- sensors ---------------------------------------------------------------------------------------------

    def recorded_wrench(self, arm: str, wrench_a: Array, parameters: Array | None = None) -> Array:
        """What the sensor of an arm records of a true wrench (..., 6) in {a}."""
        parameters = self.parameters if parameters is None else parameters
        for effect, where in self.sensor_effects:
            if effect.concerns(arm):
                wrench_a = effect.recorded(wrench_a, parameters[..., where])
        return wrench_a

    def corrected_wrench(self, arm: str, wrench_a: Array, parameters: Array | None = None) -> tuple[Array, Array]:
        """The true wrench (..., 6) behind a recorded one, and its partials by the parameters (..., 6, p)."""
        parameters = self.parameters if parameters is None else parameters
        lead = np.broadcast_shapes(wrench_a.shape[:-1], parameters.shape[:-1])
        by_parameters = np.zeros((*lead, 6, parameters.shape[-1]))
        for effect, where in reversed(self.sensor_effects):
            if effect.concerns(arm):
                contribution = effect.corrected(wrench_a, parameters[..., where])
                if contribution.by_memory is not None:
                    by_parameters = contribution.by_memory @ by_parameters
                by_parameters[..., where] += contribution.by_parameters
                wrench_a = contribution.value
        return wrench_a, by_parameters

    # --- parts -----------------------------------------------------------------------------------------------

    def _situation(
        self, state: Array, parameters: Array, time: Any
    ) -> tuple[Situation, list[tuple[slice, Contribution]]]:
        changes = [(s, e.phi_change(time, parameters[..., s])) for e, s in self.inertia_effects]
        phi = parameters[..., :N_PHI]
        for _, change in changes:
            phi = phi + change.value
        velocity_b = state[..., self.velocity_slice] @ self.basis_b.T
        return Situation(time, state[..., :3], velocity_b, phi, self.wheel_set), changes

    def _effects(self, situation: Situation, state: Array, parameters: Array) -> Array:
        memory = state[..., self.memory_slice]
        lead = np.broadcast_shapes(state.shape[:-1], parameters.shape[:-1], np.shape(situation.time))
        total = np.zeros((*lead, 3))
        for effect, where, own in self.force_effects:
            total += effect.wrench_b(situation, memory[..., own], parameters[..., where]).value
        return total

    def _memory_rate(
        self, situation: Situation, state: Array, parameters: Array, out: tuple[Array, Array, Array]
    ) -> None:
        value, by_state, by_parameters = out
        first = self.memory_slice.start
        for effect, where, memory in self.force_effects:
            if memory.stop == memory.start:
                continue
            rows = slice(first + memory.start, first + memory.stop)
            rate = effect.memory_rate(situation, state[..., rows], parameters[..., where])
            value[..., rows] = rate.value
            if rate.by_pose is not None:
                by_state[..., rows, :3] = rate.by_pose
            if rate.by_velocity is not None:
                by_state[..., rows, self.velocity_slice] = rate.by_velocity @ self.basis_b
            if rate.by_memory is not None:
                by_state[..., rows, rows] = rate.by_memory
            if rate.by_parameters is not None:
                by_parameters[..., rows, where] = rate.by_parameters


class _Wrench:
    """Sum of the force effects' wrenches and partials; this is the only place that adds them up."""

    def __init__(self, model: CartModel, situation: Situation, state: Array, parameters: Array) -> None:
        memory = state[..., model.memory_slice]
        lead = np.broadcast_shapes(state.shape[:-1], parameters.shape[:-1], np.shape(situation.time))
        self.value = np.zeros((*lead, 3))
        self.by_pose = np.zeros((*lead, 3, 3))
        self.by_velocity = np.zeros((*lead, 3, 3))
        self.by_phi = np.zeros((*lead, 3, N_PHI))
        self.by_memory = np.zeros((*lead, 3, memory.shape[-1]))
        self.by_parameters = np.zeros((*lead, 3, parameters.shape[-1]))
        for effect, where, own in model.force_effects:
            part = effect.wrench_b(situation, memory[..., own], parameters[..., where])
            self.value += part.value
            for total, partial, columns in (
                (self.by_pose, part.by_pose, slice(None)),
                (self.by_velocity, part.by_velocity, slice(None)),
                (self.by_phi, part.by_phi, slice(None)),
                (self.by_memory, part.by_memory, own),
                (self.by_parameters, part.by_parameters, where),
            ):
                if partial is not None:
                    total[..., columns] += partial


def _apply(matrix: Array, vector: Array) -> Array:
    return np.asarray((matrix @ vector[..., None])[..., 0])
