"""What an arm can give at a contact, and what it costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .contacts import ContactSet, Segment
from .errors import UsageError
from .frames import Array
from .joint_torques import LARGEST_NUMBER, JointTorques
from .reach import Reach

EXACT = "exact"
LARGEST_FRICTION = 100.0


@dataclass(frozen=True)
class Friction:
    """Coulomb friction at a contact whose normal is {a}'s x; the arm only pushes (fx >= 0).

    `sides` is the number of sides of the pyramid inscribed in the cone, with edges at 2 pi k / sides from y,
    or "exact" for the cone itself.
    """

    mu: float
    sides: int | str = 4

    def __post_init__(self) -> None:
        if not 0 <= self.mu <= LARGEST_FRICTION:
            raise UsageError(f"friction: mu: {self.mu} is not a finite number >= 0 and up to {LARGEST_FRICTION:g}")
        if self.sides != EXACT and not (isinstance(self.sides, int | np.integer) and 3 <= self.sides <= 256):
            raise UsageError(f'friction: sides: {self.sides!r} is neither a whole number of 3 to 256 nor "exact"')
        object.__setattr__(self, "sides", self.sides if self.sides == EXACT else int(self.sides))


@dataclass(frozen=True, init=False)
class Arm:
    """An arm: where it may hold (`contacts`), yaw of {a} against {b} (rad), symmetric limits per axis of {a}
    (N, N·m; `inf` for none), friction, and weights of (fx, fy, fz, tx, ty, tz) in the effort.

    It may say more: that it only pushes (fx >= 0, as friction implies), its rated `payload` (kg, whose weight it
    gives at most up or down), `wrench_rate` (N/s and N·m/s per axis, (6,)), what its `joints` bear, and its `reach`.
    """

    name: str
    contacts: ContactSet
    yaw: float
    force_limit: tuple[float, float, float]
    moment_limit: tuple[float, float, float]
    friction: Friction | None
    weights: tuple[float, float, float, float, float, float]
    push_only: bool
    payload: float
    wrench_rate: tuple[float, float, float, float, float, float]
    joints: JointTorques | None
    reach: Reach | None

    def __init__(
        self,
        name: str,
        contacts: Sequence[Sequence[float]] | ContactSet = (),
        *,
        segment: Sequence[Sequence[float]] | None = None,
        yaw: float = 0.0,
        force_limit: Sequence[float] = (np.inf,) * 3,
        moment_limit: Sequence[float] = (np.inf,) * 3,
        friction: Friction | None = None,
        weights: Sequence[float] = (1.0, 1.0, 1.0, 10.0, 10.0, 10.0),
        push_only: bool = False,
        payload: float = np.inf,
        wrench_rate: Sequence[float] = (np.inf,) * 6,
        joints: JointTorques | None = None,
        reach: Reach | None = None,
    ) -> None:
        if not isinstance(name, str) or not name or "." in name or ":" in name:
            raise UsageError(f"arm: name {name!r} must be a word without a dot or a colon")
        if not isinstance(contacts, ContactSet):
            contacts = _contact_set(name, contacts, segment)
        elif segment is not None:
            raise UsageError(f"arm {name}: segment: put it into the ContactSet that is given, not beside it")
        values = {
            "name": name,
            "contacts": contacts,
            "yaw": _number(name, "yaw", yaw),
            "force_limit": _numbers(name, "force_limit", force_limit, 3),
            "moment_limit": _numbers(name, "moment_limit", moment_limit, 3),
            "friction": friction,
            "weights": _numbers(name, "weights", weights, 6),
            "push_only": bool(push_only),
            "payload": _number(name, "payload", payload),
            "wrench_rate": _numbers(name, "wrench_rate", wrench_rate, 6),
            "joints": joints,
            "reach": reach,
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)
        if not np.isfinite(self.yaw):
            raise UsageError(f"arm {name}: yaw: {yaw} is not finite")
        if not np.isfinite(self.weights).all():
            raise UsageError(f"arm {name}: weights: {list(self.weights)} has a value that is not finite")
        if not (0 <= self.payload <= LARGEST_NUMBER or self.payload == np.inf):
            raise UsageError(f"arm {name}: payload: {payload} is not a number >= 0, in kg, nor `inf`")
        if not min(self.wrench_rate) > 0:
            raise UsageError(f"arm {name}: wrench_rate: {list(self.wrench_rate)} has a rate that is not > 0")

    @property
    def wrench_limit(self) -> Array:
        """Largest |wrench| per axis of {a}, shape (6,)."""
        return np.array([*self.force_limit, *self.moment_limit])


def _contact_set(name: str, points: Sequence[Sequence[float]], segment: Sequence[Sequence[float]] | None) -> ContactSet:
    def triple(point: Sequence[float]) -> tuple[float, float, float]:
        return _numbers(name, "contact", point, 3)  # type: ignore[return-value]

    if segment is not None and len(segment) != 2:
        raise UsageError(f"arm {name}: segment: 2 ends are needed, {len(segment)} given")
    segments = () if segment is None else (Segment(triple(segment[0]), triple(segment[1])),)
    return ContactSet(tuple(triple(p) for p in points), segments)


def _number(arm: str, what: str, value: float) -> float:
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise UsageError(f"arm {arm}: {what}: {value!r} is not a number") from error


def _numbers(arm: str, what: str, values: Sequence[float], n: int) -> tuple[float, ...]:
    try:
        numbers = tuple(float(v) for v in values)
    except (TypeError, ValueError) as error:
        raise UsageError(f"arm {arm}: {what}: {values!r} is not a row of numbers") from error
    if len(numbers) != n:
        raise UsageError(f"arm {arm}: {what}: {n} numbers are needed, {len(numbers)} given")
    if any(np.isnan(v) for v in numbers):
        raise UsageError(f"arm {arm}: {what}: {list(numbers)} holds a NaN")
    if any(LARGEST_NUMBER < abs(v) < np.inf for v in numbers):
        beyond = f"has a number beyond {LARGEST_NUMBER:g}; for no limit, give inf"
        raise UsageError(f"arm {arm}: {what}: {list(numbers)} {beyond}")
    if what.endswith("limit") and any(v < 0 for v in numbers):
        raise UsageError(f"arm {arm}: {what}: {list(numbers)} has a negative limit; limits are symmetric, >= 0")
    if what == "weights" and any(v < 0 for v in numbers):
        raise UsageError(f"arm {arm}: weights: {list(numbers)} has a negative weight")
    return numbers
