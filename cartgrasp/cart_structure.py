"""`CartStructure`: what a cart is made of, and what follows of it without a state: names, slices, free velocities.

Parameters are `(phi | effects' values)`, a state is `(x, y, theta | nu | memory)`. Carts that differ in numbers alone
share what doesn't depend on them (`SharedProperty`).
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from .checks import MAX_DISTANCE, check_kind, listed, number
from .constraints import RollingConstraints
from .effects import KNOWN_EFFECTS, ConstraintEffect, Effect, ForceEffect, InertiaEffect, SensorEffect, UnknownSlope
from .errors import UsageError
from .first_guess import FirstGuess
from .frames import Array
from .inertia import N_PHI, PHI_NAMES, Inertia
from .shared_property import SharedProperty
from .tracked_point import composed
from .wheels import Wheel, WheelSet

N_POSE = 3


# Many methods: each names, in three lines, one thing that follows from the cart's parts alone. Estimator,
# tracker and planner ask for them by these names, and what needs no numbers is kept for all carts of one structure.
@dataclass(frozen=True)
class CartStructure(ABC):
    """The cart's parts: what is pushed, and what acts on it. Frozen; `with_...` returns another."""

    inertia: Inertia
    constraints: RollingConstraints = RollingConstraints()
    effects: tuple[Effect, ...] = ()
    wheels: tuple[Wheel, ...] = ()
    com_height: float | None = None
    name: str = "cart"
    first_guess: FirstGuess = field(default_factory=FirstGuess)
    source: str = field(default="", repr=False, compare=False)

    def __post_init__(self) -> None:
        check_kind("cart: inertia", self.inertia, Inertia, "write Inertia(mass, (x, y), inertia about the CoM)")
        check_kind("cart: constraints", self.constraints, RollingConstraints, "write RollingConstraints(axle_x=0.0)")
        check_kind("cart: name", self.name, str, 'write name="cart"')
        check_kind("cart: first_guess", self.first_guess, FirstGuess, "write FirstGuess(std, known)")
        form = f"write effects=(RollingResistance(), …); known are {', '.join(KNOWN_EFFECTS)}"
        object.__setattr__(self, "effects", listed("cart: effects", self.effects, Effect, form))
        form = "write wheels=(Wheel('fixed', x, y), …)"
        object.__setattr__(self, "wheels", listed("cart: wheels", self.wheels, Wheel, form))
        if self.com_height is not None:
            number("cart: com_height", self.com_height, 0.0, MAX_DISTANCE, "give m above the floor")
        for effect in self.effects:
            if KNOWN_EFFECTS.get(effect.name, type(effect)) is not type(effect):
                why = f"{type(effect).__name__} has the name of an effect of the library; give it one of its own"
                raise UsageError(f"effects: {effect.key}: {why}")
        keys = [effect.key for effect in self.effects]
        for key in keys:
            if keys.count(key) > 1:
                raise UsageError(f"effects: {key} stands twice; give each its own label")
        if self.constraints.angle:
            raise UsageError("constraints: wheels at an angle are the effect wheel_misalignment; add it to the effects")
        for effect in self.constraint_effects:
            effect.check(self.constraints)

    def with_effect(self, effect: Effect) -> Self:
        """The cart with one more effect."""
        return replace(self, effects=(*self.effects, effect))

    @cached_property
    def on_slope(self) -> Self:
        """The cart on a floor of unknown slope, which is its last effect; level unless numbers say otherwise."""
        return self.with_effect(UnknownSlope())

    def without_effect(self, key: str) -> Self:
        """The cart without the effect called `key` (`name` or `name.label`)."""
        left = tuple(effect for effect in self.effects if effect.key != key)
        if len(left) == len(self.effects):
            known = ", ".join(effect.key for effect in self.effects) or "none"
            raise UsageError(f"effects: this cart has no {key}; it has {known}")
        return replace(self, effects=left)

    def with_inertia(self, inertia: Inertia) -> Self:
        check_kind("cart: inertia", inertia, Inertia, "write Inertia(mass, (x, y), inertia about the CoM)")
        return self._with_numbers(inertia, self.effects)

    def with_parameters(self, parameters: ArrayLike) -> Self:
        """The same structure with other numbers (p,). The last one made is kept: estimator, tracker and planner ask for
        it one after the other."""
        parameters = np.asarray(parameters, dtype=float)
        if parameters.shape != self.parameters.shape:
            raise UsageError(f"cart: parameters {parameters.shape} are not the {len(self.parameters)} of this cart")
        asked, latest = parameters.tobytes(), self.structure.get("latest")
        if latest is not None and latest[0] == asked:
            return latest[1]  # type: ignore[no-any-return]
        effects = tuple(e.with_values(parameters[s]) for e, s in zip(self.effects, self._slices, strict=True))
        made = self._with_numbers(Inertia.from_phi(parameters[:N_PHI]), effects)
        self.structure["latest"] = asked, made
        return made

    def _with_numbers(self, inertia: Inertia, effects: tuple[Effect, ...]) -> Self:
        """A cart with other numbers. Both share the structure and what is derived from it, unless constraint effects
        change."""
        other = object.__new__(type(self))
        own = {name: self.__dict__[name] for name in self.__dataclass_fields__}
        other.__dict__.update(own, inertia=inertia, effects=effects)
        if other.constraint_effects == self.constraint_effects:
            other.__dict__["structure"] = self.structure
        return other

    @cached_property
    def structure(self) -> dict[str, Any]:
        """What has been worked out of this cart without its numbers, by name; see `SharedProperty`."""
        return {}

    @cached_property
    def force_effects(self) -> tuple[tuple[ForceEffect, slice, slice], ...]:
        """Each with its slices of the parameters and of the memory."""
        each = zip(self.effects, self._slices, self._memories, strict=True)
        return tuple((effect, own, memory) for effect, own, memory in each if isinstance(effect, ForceEffect))

    @property
    def memory_drivers(self) -> tuple[ForceEffect, ...]:
        """The effects that say how the memory moves, in its order."""
        return tuple(effect for i in self._drivers if isinstance(effect := self.effects[i], ForceEffect))

    @cached_property
    def inertia_effects(self) -> tuple[tuple[InertiaEffect, slice], ...]:
        return tuple((e, s) for e, s in zip(self.effects, self._slices, strict=True) if isinstance(e, InertiaEffect))

    @cached_property
    def sensor_effects(self) -> tuple[tuple[SensorEffect, slice], ...]:
        return tuple((e, s) for e, s in zip(self.effects, self._slices, strict=True) if isinstance(e, SensorEffect))

    @SharedProperty
    def feels_motion(self) -> bool:
        """Whether what a sensor records of a wrench depends on how its hand moves."""
        return any(effect.feels_motion for effect, _ in self.sensor_effects)

    @cached_property
    def pose_tb(self) -> Array:
        """Where {b} is in the frame that is tracked, (3,): along all offsets, one after another."""
        pose = np.zeros(3)
        for effect, where in self.sensor_effects:
            if effect.moves_pose:
                pose = composed(pose, effect.pose_tb(self.parameters[where]))
        return pose

    @SharedProperty
    def pose_indices(self) -> Sequence[int]:
        """Indices of the parameters that move {b} in the tracked frame."""
        return [i for effect, where in self.sensor_effects if effect.moves_pose for i in range(where.start, where.stop)]

    @cached_property
    def constraint_effects(self) -> tuple[ConstraintEffect, ...]:
        return tuple(e for e in self.effects if isinstance(e, ConstraintEffect))

    @SharedProperty
    def rolling(self) -> RollingConstraints:
        """The constraints as effects leave them."""
        constraints = self.constraints
        for effect in self.constraint_effects:
            constraints = effect.rolling(constraints)
        return constraints

    @SharedProperty
    def slip_compliance(self) -> float:
        """Angle, rad, at which the rolling wheels creep sideways under each newton of side force."""
        return sum(effect.slip_compliance for effect in self.constraint_effects)

    @SharedProperty
    def wheel_set(self) -> WheelSet:
        return WheelSet.of(self.wheels, rolls_along_x=self.constraints.n_rows > 0)

    @SharedProperty
    def basis_b(self) -> Array:
        return self.rolling.basis_b

    @cached_property
    def parameters(self) -> Array:
        """(phi | effects' values), shape (p,)."""
        return np.concatenate([self.inertia.phi, *(effect.values for effect in self.effects)])

    @SharedProperty
    def parameter_names(self) -> tuple[str, ...]:
        return PHI_NAMES + tuple(key for effect in self.effects for key in effect.keys)

    def drives(self, effect: Effect) -> bool:
        """Whether an effect of the cart says how its memory moves."""
        return any(driver is effect for driver in self.memory_drivers)

    @SharedProperty
    def memory_names(self) -> tuple[str, ...]:
        return tuple(n for effect in self.memory_drivers for n in effect.memory_names(self.wheel_set))

    @property
    def memory_key(self) -> Hashable:
        """What the memory along a motion depends on: carts with the same key remember the same."""
        own = tuple((e.memory_names(self.wheel_set), e.memory_numbers) for e in self.memory_drivers)
        return own, self.wheels, self.basis_b.tobytes()

    @SharedProperty
    def memory_spread(self) -> Array:
        """How far (k,) the true memory may be from the first."""
        spreads = [effect.memory_spread(self.wheel_set) for effect in self.memory_drivers]
        return np.concatenate([np.zeros(0), *spreads])

    @SharedProperty
    def memory_is_seen(self) -> Array:
        """Mask (k,) of the memories that the motion alone determines."""
        return np.array([e.memory_is_seen for e in self.memory_drivers for _ in e.memory_names(self.wheel_set)], bool)

    @SharedProperty
    def state_names(self) -> tuple[str, ...]:
        return ("x", "y", "theta", *self.constraints.velocity_names, *self.memory_names)

    @SharedProperty
    def velocity_slice(self) -> slice:
        return slice(N_POSE, N_POSE + self.constraints.n_free)

    @SharedProperty
    def memory_slice(self) -> slice:
        return slice(self.velocity_slice.stop, len(self.state_names))

    @SharedProperty
    def _memories(self) -> tuple[slice, ...]:
        """What is each effect's of the memory. Effects that name the same memory share it."""
        slices, taken, start = [], dict[tuple[str, ...], slice](), 0
        for effect in self.effects:
            names = effect.memory_names(self.wheel_set) if isinstance(effect, ForceEffect) else ()
            own = taken.setdefault(names, slice(start, start + len(names)))
            start = max(start, own.stop)
            slices.append(own)
        return tuple(slices)

    @SharedProperty
    def _drivers(self) -> tuple[int, ...]:
        """Which effects say how the memory moves: of those that share one, the first that drives it, or the first."""
        found = dict[int, int]()
        for drives in (True, False):
            for i, (effect, own) in enumerate(zip(self.effects, self._memories, strict=True)):
                if own.stop > own.start and isinstance(effect, ForceEffect) and effect.drives_memory is drives:
                    found.setdefault(own.start, i)
        return tuple(found[start] for start in sorted(found))

    @SharedProperty
    def _slices(self) -> tuple[slice, ...]:
        slices, start = [], N_PHI
        for effect in self.effects:
            slices.append(slice(start, start + len(effect.parameters)))
            start += len(effect.parameters)
        return tuple(slices)

    def state(self, pose_sb: ArrayLike = (0.0, 0.0, 0.0), velocity: ArrayLike | None = None) -> Array:
        """A state (n,) at a pose and free velocity (0 unless given), with effects' first memory."""
        velocity = np.zeros(self.constraints.n_free) if velocity is None else np.asarray(velocity, float)
        if velocity.shape != (self.constraints.n_free,):
            raise UsageError(
                f"model: velocity has shape {velocity.shape}, but this cart's {self.constraints.n_free} numbers"
            )
        velocity_b = self.basis_b @ velocity
        memory: Sequence[Array] = [e.first_memory(self.wheel_set, velocity_b) for e in self.memory_drivers]
        return np.concatenate([np.asarray(pose_sb, float), velocity, *memory])
