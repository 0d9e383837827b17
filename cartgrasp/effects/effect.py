"""What an effect is: named parameters, an own memory, and one contribution with analytic partials.

A `ForceEffect` acts on the cart, an `InertiaEffect` changes phi, a `ConstraintEffect` changes how it rolls, a
`SensorEffect` stands between the true and the recorded wrench of an arm. `CartModel` alone decides signs and sums.
The library's force and inertia effects have a kernel (`compiled.py`). A class from outside that works out its
contributions in numpy has its place beside them, and sensor and constraint effects are numpy, too.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from ..checks import number
from ..constraints import RollingConstraints
from ..errors import SettingError, UsageError
from ..frames import Array, rotation_planar
from ..wheels import WheelSet

SMOOTHING_SPEED = 0.002
"""m/s: below it a Coulomb force fades to zero, so that dynamics stay smooth."""


TYPICAL_MEMORY_SPREAD = 0.5
"""Usual spread of a memory about its first value, in its own unit: rad for an angle."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect. `typical` is the usual distance from `absent`, and the first guess's uncertainty.
    Where and when something acts is not `estimated` online: it enters far from linearly. What is `optional` is, where
    it is not absent and has no `grid`; fits of logs estimate it. What `is_by_mass` acts as its product with the mass. A
    search for an effect that nobody has named begins at the values of `grid`, or at `absent`."""

    name: str
    unit: str
    typical: float
    lower: float = -np.inf
    upper: float = np.inf
    absent: float = 0.0
    estimated: bool = True
    optional: bool = False
    is_by_mass: bool = False
    grid: tuple[float, ...] = ()


@dataclass(frozen=True)
class Setting:
    """A field of an effect that is no parameter, but says of what form it is: one of some `words`, a finite number, or
    a list of such, which increase."""

    name: str
    words: tuple[str, ...] = ()
    is_list: bool = False

    def check(self, key: str, value: Any) -> None:
        """Refuses what the effect called `key` can't have."""
        if self.words:
            if value not in self.words:
                raise SettingError(key, self.name, f"{value!r} is none of {', '.join(self.words)}")
            return
        numbers = value if self.is_list else (value,)
        if not all(math.isfinite(number) for number in numbers):
            raise SettingError(key, self.name, f"{value} is not finite")
        if any(b <= a for a, b in pairwise(numbers)):
            raise SettingError(key, self.name, f"{list(value)} does not increase")


class Gate(Enum):
    """When and where an effect acts, and by which of its parameters: always; from its first on (s); for a while, from
    its first (s), as long as its second (s); or between its first and second along x, its third and fourth along y
    (m, of {s})."""

    ALWAYS = "always"
    FROM = "from"
    WHILE = "while"
    INSIDE = "inside"

    @property
    def n_parameters(self) -> int:
        return {Gate.ALWAYS: 0, Gate.FROM: 1, Gate.WHILE: 2, Gate.INSIDE: 4}[self]

    @property
    def passes(self) -> bool:
        """Whether it is a time."""
        return self in (Gate.FROM, Gate.WHILE)

    @property
    def ends(self) -> bool:
        """Whether it is a time that is over: what happens once can't be learned from another part of a log."""
        return self is Gate.WHILE


class Wall(NamedTuple):
    """Where a cart bounces at once: {b}'s origin gets no further than `position` (m, along x of {s}), coming from
    smaller x (`side` 1) or from larger x (`side` -1), and goes back with a share `restitution` of its speed there."""

    position: float
    side: float
    restitution: float


@dataclass(frozen=True)
class Situation:
    """What an effect may look at; arrays broadcast over leading axes. Velocity is (u, w, r) in {b}."""

    time: Any
    pose_sb: Array
    velocity_b: Array
    phi: Array
    wheels: WheelSet


class HandMotion(NamedTuple):
    """How a hand moves with the cart that it holds, for sensors that feel what hangs on them. In {a}: acceleration
    (..., 3) of its origin, m/s², without gravity; yaw rate (...), rad/s, and its rate (...), rad/s²."""

    acceleration: Array
    yaw_rate: Array
    yaw_acceleration: Array

    @classmethod
    def of(cls, velocity_b: Array, rate_b: Array, contact_b: ArrayLike, yaw: ArrayLike = 0.0) -> HandMotion:
        """The motion of a hand that holds at a point (..., 3) of {b}. {b} moves at (u, w, r) (..., 3), and `rate_b`
        (..., 3) is (u', w', r'). With q the point, `a = (u' - r w, w' + r u) + r' z x q - r² q`."""
        (u, w, r), (u_rate, w_rate, r_rate) = (np.moveaxis(part, -1, 0) for part in (velocity_b, rate_b))
        x, y, _ = np.moveaxis(np.asarray(contact_b, dtype=float), -1, 0)
        forward = u_rate - r * w - r_rate * y - r * r * x
        left = w_rate + r * u + r_rate * x - r * r * y
        in_a = (rotation_planar(-np.asarray(yaw, dtype=float)) @ np.stack([forward, left], -1)[..., None])[..., 0]
        return cls(np.concatenate([in_a, np.zeros((*in_a.shape[:-1], 1))], axis=-1), r, r_rate)


HAND_AT_REST = HandMotion(np.zeros(3), np.zeros(()), np.zeros(()))


@dataclass(frozen=True)
class Contribution:
    """A value (..., k) and its partials (..., k, n); None where it does not depend on the argument."""

    value: Array
    by_pose: Array | None = None
    by_velocity: Array | None = None
    by_phi: Array | None = None
    by_memory: Array | None = None
    by_parameters: Array | None = None


@dataclass(frozen=True, kw_only=True, init=False)
class Effect(ABC):
    """Base of all. Fields named in `parameters` are the values, those in `settings` say of what form it is; `label`
    tells several of one kind apart (for a sensor effect it names the arm; empty: every arm). At its defaults an effect
    is absent."""

    label: str = field(default="", kw_only=True)

    name: ClassVar[str]
    settings: ClassVar[tuple[Setting, ...]] = ()
    signature: ClassVar[str]
    ordered: ClassVar[tuple[tuple[str, str], ...]] = ()
    gate: ClassVar[Gate] = Gate.ALWAYS
    searched: ClassVar[bool] = True
    """Whether a search in balances of forces offers it; else it is found by other means."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """What it has numbers for; the same for all of a class, unless settings say which."""

    def __init__(self, *values: Any, label: str = "", **others: Any) -> None:
        """Whoever is no dataclass gets here: one without values needs to be none."""
        if values or others or self.parameters:
            cure = (
                "put @dataclass(frozen=True) above it, and give each parameter a field such as `strength: float = 0.0`"
            )
            raise UsageError(f"{type(self).__name__}: the class of an effect with values is a dataclass; {cure}")
        object.__setattr__(self, "label", label)
        self.__post_init__()

    def __post_init__(self) -> None:
        for parameter in self.parameters:
            if not isinstance(value := getattr(self, parameter.name, 0.0), float):
                number(f"{self.key}.{parameter.name}", value, cure=f"give {parameter.unit}")
        for parameter, value in zip(self.parameters, self.values.tolist(), strict=True):
            if not math.isfinite(value):
                raise UsageError(f"{self.key}.{parameter.name}: {value} is not a finite number")
            if not parameter.lower <= value <= parameter.upper:
                raise UsageError(
                    f"{self.key}.{parameter.name}: {value:g} {parameter.unit} is outside "
                    f"[{parameter.lower:g}, {parameter.upper:g}]"
                )
        for low, high in self.ordered:
            if getattr(self, low) > getattr(self, high):
                raise UsageError(f"{self.key}.{low}: {getattr(self, low):g} is above {high} = {getattr(self, high):g}")

    @property
    def key(self) -> str:
        """`name`, or `name.label`."""
        return f"{self.name}.{self.label}" if self.label else self.name

    @property
    def keys(self) -> tuple[str, ...]:
        """Full names of the parameters."""
        return tuple(f"{self.key}.{p.name}" for p in self.parameters)

    @cached_property
    def values(self) -> Array:
        return np.array([getattr(self, p.name) for p in self.parameters], dtype=float)

    def grids(self, wheels: WheelSet) -> tuple[tuple[float, ...], ...]:
        """For each parameter, the values where a search begins on a cart with these wheels; empty where there are
        none."""
        return tuple(parameter.grid for parameter in self.parameters)

    @property
    def lateness(self) -> float:
        """How long after it was felt a sample is recorded, s."""
        return 0.0

    def with_values(self, values: ArrayLike) -> Self:
        """The same effect with other parameter values (n,); they are brought inside their bounds."""
        clipped: dict[str, Any] = {
            p.name: min(max(value, p.lower), p.upper)
            for p, value in zip(self.parameters, np.asarray(values, dtype=float).tolist(), strict=True)
        }
        return replace(self, **clipped)


class ForceEffect(Effect):
    """Acts on the cart with a planar wrench about {b}'s origin, in {b}."""

    def memory_names(self, wheels: WheelSet) -> tuple[str, ...]:
        """Names of the internal states; none for most."""
        return ()

    def first_memory(self, wheels: WheelSet, velocity_b: Array) -> Array:
        """The memory (k,) of a cart that has just come to be looked at, at a velocity (3,)."""
        return np.zeros(len(self.memory_names(wheels)))

    def memory_spread(self, wheels: WheelSet) -> Array:
        """How far (k,) the true memory may be from the first; in proportion to it, what is believed of it fades."""
        return np.full(len(self.memory_names(wheels)), TYPICAL_MEMORY_SPREAD)

    memory_is_seen: ClassVar[bool] = False
    """Whether the motion alone tells its memory, such as a way; else it may be another than it is believed to be."""

    drives_memory: ClassVar[bool] = True
    """Whether it says how its memory moves where another effect has the same one."""

    @property
    def memory_numbers(self) -> tuple[float, ...]:
        """The numbers on which its memory along a motion depends."""
        return tuple(self.values.tolist())

    @abstractmethod
    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        """The wrench (..., 3) it applies to the cart, with partials."""

    @property
    def wall(self) -> Wall | None:
        """Where the cart bounces at once; None where it does nowhere."""
        return None

    def quickness(self, mass: float) -> float:
        """How fast (1/s) it may change the motion of a cart of this mass (kg) where it sets in; 0 where nothing sets in
        that was not to be seen before."""
        return 0.0

    stuck_for: ClassVar[float] = 0.1
    """s: how long a force of `stiction` keeps its value, which may be any up to the whole."""

    @property
    def stuck_root(self) -> float:
        """√s: the root of its density as noise, for a force of 1 to either side: the square of what is as likely
        everywhere within it is a third, in the mean."""
        return math.sqrt(self.stuck_for / 3.0)

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array | None:
        """Wrenches (..., 3, k), in {b}, that may act beside `wrench_b` near standstill, where a Coulomb force
        takes whatever value holds things still; they vanish with speed. None where there is no such force."""
        return None

    def memory_rate(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        """Time derivative of the memory (..., k), with partials."""
        return Contribution(np.zeros_like(memory))

    def settled_memory(self, situation: Situation, memory: Array) -> Array:
        """Where the memory (..., k) comes to rest when the motion goes on as it is."""
        return memory


class InertiaEffect(Effect):
    """Changes the inertial parameters."""

    @abstractmethod
    def phi_change(self, time: Any, parameters: Array) -> Contribution:
        """What is added to phi (..., 4), with partials by parameters."""


class ConstraintEffect(Effect):
    """Changes what the fixed wheels forbid. Its values belong to the structure of a model: another value is another
    model, partials by it are 0, and it is not looked up in the parameters that a model's functions are given."""

    def check(self, constraints: RollingConstraints) -> None:
        """Refuses a cart without fixed wheels."""
        if constraints.axle_x is None:
            raise UsageError(f"{self.key}: the cart has no fixed wheels; add the constraint no_lateral_slip")

    @classmethod
    @abstractmethod
    def usual(cls, label: str) -> Self:
        """One of usual size, with which a search begins."""

    @abstractmethod
    def scaled(self, share: float) -> Self:
        """The same effect with `share` times the velocity across the cart."""

    @property
    def slip_compliance(self) -> float:
        """Angle, rad, at which a rolling wheel creeps sideways under each newton of side force."""
        return 0.0

    def rolling(self, constraints: RollingConstraints) -> RollingConstraints:
        """What is left of the constraints."""
        return constraints


class SensorEffect(Effect):
    """Stands between the true wrench (..., 6) in {a} and the recorded one, or between the true pose and the recorded
    one; `label` names the arm. What arms have together, such as a clock, is not `by_arm`."""

    by_arm: ClassVar[bool] = True
    feels_motion: ClassVar[bool] = False
    """Whether what is recorded depends on how the hand moves; others ignore it."""
    moves_pose: ClassVar[bool] = False
    """Whether another frame than {b} is tracked."""

    def concerns(self, arm: str) -> bool:
        return self.label in ("", arm)

    @abstractmethod
    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        """What the sensor records of a true wrench."""

    @abstractmethod
    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        """The true wrench behind a recorded one, with partials by parameters (..., 6, p) and, as `by_memory`,
        by the recorded wrench (..., 6, 6; None: the identity)."""

    def pose_tb(self, parameters: Array) -> Array:
        """Where {b} is in the frame that is tracked, (3,)."""
        return np.zeros(3)


class LeavesWrenches(SensorEffect):
    """A sensor effect that records wrenches as they are."""

    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        return wrench_a

    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        lead = np.broadcast_shapes(wrench_a.shape[:-1], parameters.shape[:-1])
        by_parameters = np.zeros((*lead, 6, len(self.parameters)))
        return Contribution(np.broadcast_to(wrench_a, (*lead, 6)), by_parameters=by_parameters)
