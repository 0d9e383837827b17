"""`CartModel`: how a cart of an inertia, rolling constraints and effects moves.

With S the basis of the free velocities, the reduced dynamics are (physics.md)

    Sᵀ M_b S nu' = Sᵀ (wrench_b + effects - bias),    pose' = R(theta) S nu,

where M_b lacks what swings along x (`effects/load_slosh.py`).

They are in the body frame, where S is constant. Every function broadcasts over leading axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from .cart_structure import CartStructure
from .checks import brief, digits
from .effects import ForceEffect, InertiaEffect
from .effects.compiled import CompiledForce, CompiledInertia
from .effects.effect import HAND_AT_REST, SMOOTHING_SPEED, HandMotion, Situation
from .frames import Array
from .inertia import N_PHI
from .shared_property import SharedProperty

if TYPE_CHECKING:
    import os
    from pathlib import Path

    from .compiled_dynamics import CompiledDynamics, StatePoint
    from .kernels.situation import Parts


@dataclass(frozen=True)
class StateRate:
    """Rate of the state (..., n) and its partials by state (n), planar wrench in {b} (3) and parameters (p)."""

    value: Array
    by_state: Array
    by_wrench: Array
    by_parameters: Array


@dataclass(frozen=True)
class InverseDynamics:
    """The reduced wrench `Sᵀ wrench_b` (..., f) that an acceleration takes, its partials by nu' (..., f, f), parameters
    (..., f, p) and state (..., f, n); and the memory's rate (..., k) with its partials."""

    wrench: Array
    by_acceleration: Array
    by_parameters: Array
    by_state: Array
    memory_rate: Array
    memory_rate_by_state: Array
    memory_rate_by_parameters: Array


# Many methods: the questions of physics.md that a user asks of a cart, which the contract names; each hands on to one
# file that answers it. What is structure stands in cart_structure.py.
@final
@dataclass(frozen=True)
class CartModel(CartStructure):
    """A cart: a rigid body, what its wheels forbid, and what acts on it. Frozen: `with_...` returns another.

    Args:
        inertia: Mass (kg), CoM in {b} (m) and yaw inertia about it (kg·m²), with the load.
        constraints: What fixed wheels or a rail forbid; fixed wheels with their axle through {b}'s origin unless given.
        effects: What acts beside, from `cartgrasp.effects`; each name once, or with labels.
        wheels: For loads, skid and tip-over, casters, and drags of each wheel.
        com_height: m above the floor; tip-over needs it.
        name: What errors and reports call it.
        first_guess: How sure its numbers are: `std` and `known` of the file.
        source: The text of the file that it was read from, which `save` keeps.

    Raises:
        UsageError: A part is of the wrong kind, out of bounds, no body, or stands twice.

    Example:
        >>> import cartgrasp as cg
        >>> from cartgrasp.effects import RollingResistance
        >>> cart = cg.CartModel(cg.Inertia(mass=24.0, com=(0.3, 0.0), about_com=2.0))
        >>> cart = cart.with_effect(RollingResistance(coefficient=0.02))
        >>> rolling = cart.state(velocity=(0.5, 0.0))
        >>> cart.required_wrench(rolling, acceleration=[0.0, 0.0]).round(2).tolist()  # 0.02 of the weight, no moment
        [4.71, 0.0]
    """

    def __repr__(self) -> str:
        body, rows = self.inertia, ("all casters", "no lateral slip", "on a rail")[self.constraints.n_rows]
        what = f"{digits(body.mass)} kg, CoM {digits(body.com)} m, inertia {digits(body.about_com)} kg m²"
        effects = "; ".join(f"{e.key} {digits(e.values.tolist())}" for e in self.effects) or "none"
        return brief("CartModel", repr(self.name), what, rows, f"{len(self.wheels)} wheels", f"effects: {effects}")

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes `cart.yaml`, with the comments and order of the file it was read from."""
        from .cart_file import save_cart

        return save_cart(self, path)

    # --- motion ----------------------------------------------------------------------------------------------

    def rate(self, state: Array, wrench_b: Array, parameters: Array | None = None, time: Any = 0.0) -> StateRate:
        """Forward dynamics with analytic partials."""
        point, push = self._point(state, parameters, time), np.asarray(wrench_b)
        rates = self.dynamics.rates(point, push, self._foreign(point))
        if self.slip_compliance:
            from .creep import creeping

            rates = creeping(self, point, push, rates)
        return StateRate(*rates)

    def stiffness(self, state: Array, wrench_b: Array, time: Any = 0.0) -> float:
        """How fast (1/s) anything fades or grows at states (..., n): the largest eigenvalue; 0 if one is infinite."""
        jacobian = self.rate(state, wrench_b, time=time).by_state
        return float(np.abs(np.linalg.eigvals(jacobian)).max()) if np.isfinite(jacobian).all() else 0.0

    def state_rate(self, state: Array, wrench_b: Array, parameters: Array | None = None, time: Any = 0.0) -> Array:
        """Forward dynamics without partials: the rate of the state, (..., n)."""
        if self.slip_compliance:
            return self.rate(state, wrench_b, parameters, time).value
        point = self._point(state, parameters, time)
        return self.dynamics.rate(point, np.asarray(wrench_b), self._foreign(point))

    def inverse(
        self, state: Array, acceleration: Array, parameters: Array | None = None, time: Any = 0.0
    ) -> InverseDynamics:
        """Inverse dynamics at nu' = `acceleration` (..., n_free), with analytic partials."""
        point = self._point(state, parameters, time)
        return InverseDynamics(*self.dynamics.inverse(point, np.asarray(acceleration), self._foreign(point)))

    def inverse_by_parameters(
        self, state: Array, acceleration: Array, parameters: Array | None = None, time: Any = 0.0
    ) -> tuple[Array, Array]:
        """The reduced wrench (..., f) and its partials (..., f, p) by the parameters, for less time than `inverse`."""
        point = self._point(state, parameters, time)
        wrench, _, slopes = self.dynamics.inverse_by_parameters(point, np.asarray(acceleration), self._foreign(point))
        return wrench, slopes

    def required_wrench(
        self, state: Array, acceleration: Array, parameters: Array | None = None, time: Any = 0.0
    ) -> Array:
        """Inverse dynamics: the reduced wrench `Sᵀ wrench_b`, (..., n_free), that gives nu' = `acceleration`."""
        return self.inverse_by_parameters(state, acceleration, parameters, time)[0]

    def effect_wrench(self, state: Array, parameters: Array | None = None, time: Any = 0.0) -> Array:
        """Sum of the force effects on the cart, (..., 3), in {b}."""
        return self.effect_values(state, parameters, time)[0]

    def effect_values(self, state: Array, parameters: Array | None = None, time: Any = 0.0) -> tuple[Array, Array]:
        """The sum of the force effects, (..., 3), in {b}, and the mass that swings, (...), without partials."""
        point = self._point(state, parameters, time)
        return self.dynamics.values(self.dynamics.sums(point, self._foreign(point)))

    def effect_parts(self, point: StatePoint) -> tuple[Array, Array, Parts, Parts, Parts]:
        """At (state, time, parameters): phi with what effects add to it, its partials by the parameters, the effects'
        wrench, their memory's rate and the mass that swings, with partials."""
        return self.dynamics.parts(self.dynamics.sums(point, self._foreign(point)))

    def foreign_sums(self, state: Array, parameters: Array, time: Any = 0.0) -> Array:
        """What effects without a kernel add at a state, as kernels take it; (0,) where all have one."""
        found = self._foreign((state, time, parameters))
        return np.zeros(0) if found is None else found

    def stiction(self, state: Array, parameters: Array, time: Any = 0.0) -> Array:
        """Wrenches (..., 3, k), in {b}, that Coulomb effects may give near standstill beside their modelled ones, each
        as the root of the density (N√s, N·m√s) of white noise that does as much."""
        if self.is_compiled:
            return self.dynamics.stiction((state, time, parameters))
        situation, memory = self._situation(state, parameters, time), state[..., self.memory_slice]
        lead = np.broadcast_shapes(state.shape[:-1], np.shape(time), parameters.shape[:-1])
        found = [np.zeros((*lead, 3, 0))]
        for effect, own, remembered in self.force_effects:
            columns = effect.stiction(situation, memory[..., remembered], parameters[..., own])
            if columns is not None:
                found.append(effect.stuck_root * np.broadcast_to(columns, (*lead, *columns.shape[-2:])))
        return np.concatenate(found, axis=-1)

    def settled_memory(self, state: Array, parameters: Array, time: Any = 0.0) -> Array:
        """Where the effects' memories (..., k) come to rest when the motion goes on as it is."""
        memory = state[..., self.memory_slice]
        if not self.memory_names:
            return memory
        if self.is_compiled:
            return self.dynamics.settled((state, time, parameters))
        situation = self._situation(state, parameters, time)
        settled = [effect.settled_memory(situation, memory[..., own]) for effect, _, own in self.force_effects]
        return np.concatenate(settled, axis=-1)

    def memory_along(
        self, pose_sb: Array, velocity: Array, time: Array, parameters: Array | None = None, first: Array | None = None
    ) -> Array:
        """The effects' memories (n, k) along a motion: poses (n, 3), free velocities (n, f), times (n,)."""
        first = self.state(pose_sb[0], velocity[0])[self.memory_slice] if first is None else first
        if not self.memory_names:
            return np.zeros((len(time), 0))
        state = np.hstack([pose_sb, velocity, np.tile(first, (len(time), 1))])
        if self.is_compiled:
            return self.dynamics.memories(self._point(state, parameters, time))
        if not self._foreign_changes and all(own.start == own.stop for *_, own in self._foreign_forces):
            cart = self if parameters is None else self.with_parameters(parameters)
            known = tuple(e for e in cart.effects if not isinstance(e, ForceEffect) or isinstance(e, CompiledForce))
            return replace(cart, effects=known).memory_along(pose_sb, velocity, time, first=first)
        for i, step in enumerate(np.diff(time)):
            still = np.zeros(self.constraints.n_free)
            rate = self.inverse(state[i], still, parameters, time[i]).memory_rate
            state[i + 1, self.memory_slice] = state[i, self.memory_slice] + step * rate
        return state[:, self.memory_slice]

    def planar_wrench(self, reduced: Array) -> Array:
        """A wrench (..., 3) in {b} without side force whose effective rows `Sᵀ wrench_b` are `reduced`."""
        return np.asarray(reduced @ self.rolling.along_b)

    def phi_at(self, time: Any, parameters: Array | None = None) -> Array:
        """phi with what inertia effects add at a time, (..., 4)."""
        point = self._point(np.zeros(len(self.state_names)), parameters, time)
        return self.dynamics.sums(point, self._foreign(point))[..., :N_PHI]

    def floor_rows(self, state: Array, time: Any = 0.0, with_partials: bool = False) -> Array:
        """What the floor gives, for `FloorReaction`: of each wheel and of all fixed ones a row over the hands' spatial
        wrench with an offset behind it, (..., 1, n_wheels + 1, 7); the wheels' need `com_height`. With partials by the
        parameters behind it, (..., 1 + p, n_wheels + 1, 7)."""
        point = self._point(state, None, time)
        return self.dynamics.floor(point, np.array([self.com_height or 0.0]), self._foreign(point), with_partials)

    # --- sensors ---------------------------------------------------------------------------------------------

    def hand_motion(self, nu: Array, nu_rate: Array, contact_b: Array, yaw: float = 0.0) -> HandMotion:
        """How a hand that holds at a point (..., 3) of {b} moves, at free velocities (..., f) and their rates."""
        return HandMotion.of(nu @ self.basis_b.T, nu_rate @ self.basis_b.T, contact_b, yaw)

    def recorded_wrench(
        self, arm: str, wrench_a: Array, parameters: Array | None = None, hand: HandMotion = HAND_AT_REST
    ) -> Array:
        """What the sensor of an arm, whose hand moves so, records of a true wrench (..., 6) in {a}."""
        parameters = self.parameters if parameters is None else parameters
        for effect, where in self.sensor_effects:
            if effect.concerns(arm):
                wrench_a = effect.recorded(wrench_a, parameters[..., where], hand)
        return wrench_a

    def lateness(self, arm: str) -> float:
        """How long after it was felt the sensor of an arm records a wrench, s."""
        return sum(effect.lateness for effect, _ in self.sensor_effects if effect.concerns(arm))

    def corrected_wrench(
        self, arm: str, wrench_a: Array, parameters: Array | None = None, hand: HandMotion = HAND_AT_REST
    ) -> tuple[Array, Array]:
        """The true wrench (..., 6) behind one that was recorded while the hand moved so, and its partials by the
        parameters (..., 6, p)."""
        parameters = self.parameters if parameters is None else parameters
        lead = np.broadcast_shapes(wrench_a.shape[:-1], parameters.shape[:-1], hand.acceleration.shape[:-1])
        by_parameters = np.zeros((*lead, 6, parameters.shape[-1]))
        for effect, where in reversed(self.sensor_effects):
            if effect.concerns(arm):
                contribution = effect.corrected(wrench_a, parameters[..., where], hand)
                if contribution.by_memory is not None:
                    by_parameters = contribution.by_memory @ by_parameters
                by_parameters[..., where] += contribution.by_parameters
                wrench_a = contribution.value
        return wrench_a, by_parameters

    # --- parts -----------------------------------------------------------------------------------------------

    @SharedProperty
    def dynamics(self) -> CompiledDynamics:
        """The kernels, which need this structure and no numbers."""
        from .compiled_dynamics import CompiledDynamics
        from .kernels.workspace import PackedEffect

        forces = [(e, s, own) for e, s, own in self.force_effects if isinstance(e, CompiledForce)]
        changes = [(e, s) for e, s in self.inertia_effects if isinstance(e, CompiledInertia)]
        packed = [PackedEffect(e.name, s, own, e.constants, e.stuck_root, self.drives(e)) for e, s, own in forces]
        packed += [PackedEffect(e.name, s, slice(0, 0)) for e, s in changes]
        sizes = len(self.memory_names), len(self.parameters)
        return CompiledDynamics(packed, self.wheel_set, self.basis_b, sizes, SMOOTHING_SPEED)

    @SharedProperty
    def is_compiled(self) -> bool:
        """Whether every effect has a kernel."""
        return not (self._foreign_forces or self._foreign_changes)

    @cached_property
    def _foreign_forces(self) -> tuple[tuple[ForceEffect, slice, slice], ...]:
        return tuple(found for found in self.force_effects if not isinstance(found[0], CompiledForce))

    @cached_property
    def _foreign_changes(self) -> tuple[tuple[InertiaEffect, slice], ...]:
        return tuple(found for found in self.inertia_effects if not isinstance(found[0], CompiledInertia))

    def _point(self, state: Array, parameters: Array | None, time: Any) -> StatePoint:
        return state, time, self.parameters if parameters is None else parameters

    def _foreign(self, point: StatePoint) -> Array | None:
        """What effects without a kernel add, as the kernels take it."""
        if self.is_compiled:
            return None
        from .foreign_effects import foreign_sums

        return foreign_sums(self, point, self._foreign_forces, self._foreign_changes)

    def _situation(self, state: Array, parameters: Array, time: Any) -> Situation:
        velocity_b = state[..., self.velocity_slice] @ self.basis_b.T
        return Situation(time, state[..., :3], velocity_b, self.phi_at(time, parameters), self.wheel_set)
